"""Faults in a model's record of its fit, which people edit and other programs write."""

from collections.abc import Iterator, Mapping

_FROM_ZERO = ("cutoff", "band", "residual_stddev", "force_stddev", "force_rms")
REMEDY = "identify the model again, or remove fit"


def record_faults(fit: object) -> Iterator[str]:
    """What the node, the inverse or a diagnosis could not use, in words; entries that are not there are no faults."""
    if not isinstance(fit, Mapping):
        yield f"must be a mapping, got {fit!r}"
        return
    for name in _FROM_ZERO:
        value = fit.get(name)
        if value is not None and not (_is_number(value) and value >= 0.0):
            yield f"{name} = {value!r} is not a number from 0"
    yield from _faults_of(fit, "region", _is_range, "must be two numbers, the lower one first")
    yield from _faults_of(fit, "standard_errors", _is_number, "must be a number")


def _faults_of(fit: Mapping, name: str, is_good, rule: str) -> Iterator[str]:
    entries = fit.get(name) or {}
    if not isinstance(entries, Mapping):
        yield f"{name} must be a mapping, got {entries!r}"
        return
    yield from (f"{name}.{key} {rule}, got {value!r}" for key, value in entries.items() if not is_good(value))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300


def _is_range(value: object) -> bool:
    is_pair = isinstance(value, list | tuple) and len(value) == 2 and all(_is_number(item) for item in value)
    return is_pair and value[0] <= value[1]
