"""Limits of parameters as words: ``NAME=LOW:HIGH``."""

from collections.abc import Sequence

from damper_estimator.errors import InputError


def limits_of(words: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Lowest and highest value by name from words ``NAME=LOW:HIGH``; a side that is left out is open."""
    found = {}
    for word in words:
        name, _, ends = word.rpartition("=")
        low, colon, high = ends.partition(":")
        try:
            found[name] = (float(low or "-inf"), float(high or "inf"))
        except ValueError:
            colon = ""
        if not name or not colon:
            raise InputError(f"--limit {word}: is not NAME=LOW:HIGH, such as bouc_wen.n=1.5:8")
    return found
