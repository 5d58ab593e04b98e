"""Parses and checks options of ``fit`` and ``fleet fit``: limits, and options of several objectives."""

from collections.abc import Sequence

from damper_estimator.errors import InputError


def limits_of(words: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Lowest and highest value by name from words ``NAME=LOW:HIGH``; an omitted value means no limit."""
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


def check_objectives(method: str, options: Sequence[str]) -> None:
    """Checks that options of several objectives are used with such a method.

    Raises:
        InputError: if the method has a single objective.
    """
    from damper_estimator.identification import all_methods

    chosen = all_methods().get(method)
    if chosen is not None and options and not chosen.several:
        several = ", ".join(name for name, each in all_methods().items() if each.several)
        raise InputError(f"{', '.join(options)}: {method} has a single objective; use --method {several}")
