"""Trials of effects that follow the command or the temperature: what of it changes, and where the model holds.

A channel that stands still in the recordings explains nothing in them. It may still differ from where the model was
identified, as when a damper is driven at one current after the other; then that difference speaks for the effect.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from damper_estimator.effects.trial import Ranges, Trial, Untestable

Ends = tuple[float, float]

_STANDING = 0.05  # of the largest command: a smaller change counts as constant
_NOISE = 0.02  # A (or V): so does the noise of a current that is switched off
_LEAST_CHANGE = 2.0  # K
_LEAST_DIFFERENCE = 5.0  # K, between recordings, in which other causes differ as well
_MOVED_COMMAND = 50.0  # prior: three of four recorded commands act, the rest shares the remaining quarter
_MOVED_TEMPERATURE = 5.0  # prior: it acts on all dampers, but seldom by much


def command_moved(ranges: Ranges) -> bool:
    """Whether the recordings hold one command, beyond what the model was identified at."""
    return _moved(ranges.command, ranges.model_command, _changes_command, _changes_command)


def temperature_moved(ranges: Ranges) -> bool:
    """Whether the recordings hold one temperature, beyond what the model was identified at."""
    return _moved(ranges.temperature, ranges.model_temperature, _changes_temperature, _differs_in_temperature)


def commands(ranges: Ranges) -> Ends | None:
    """Lowest and highest command, A, from that of the model on where it moved; None where not recorded."""
    return _with(ranges.command, ranges.model_command if command_moved(ranges) else None)


def temperatures(ranges: Ranges) -> Ends | None:
    """Lowest and highest temperature, deg C, from that of the model on where it moved; None where not recorded."""
    return _with(ranges.temperature, ranges.model_temperature if temperature_moved(ranges) else None)


def changing_command(ranges: Ranges) -> Ends:
    """Lowest and highest command (A).

    Raises:
        Untestable: without a command, or with a constant one, which explains nothing.
    """
    if ranges.command is None:
        raise Untestable("no command was recorded")
    if not _changes_command(ranges.command):
        raise Untestable("the command did not change")
    return ranges.command


def moved_command(ranges: Ranges) -> Ends:
    """Lowest and highest command (A), if it changed in the recordings or since the model was identified.

    Raises:
        Untestable: as ``changing_command``.
    """
    return changing_command(ranges) if not command_moved(ranges) else _with(ranges.command, ranges.model_command)


def reference_commands(ranges: Ranges) -> tuple[float, ...]:
    """Sizes of the command at which the model may hold (A), the most probable first: where it was identified, and large
    and small recorded ones.

    Raises:
        Untestable: as ``moved_command``.
    """
    most = max(abs(value) for value in moved_command(ranges))
    known = _middle(ranges.model_command, 0.0)
    if command_moved(ranges):
        return (known,)
    return (known if known > _STANDING * most else most, most, 0.25 * most)


def zero_command(ranges: Ranges) -> float:
    """Size of the command (A) at which an effect that grows from zero adds nothing: 0, or where the model was
    identified, if the command has moved from there.
    """
    return _middle(ranges.model_command, 0.0) if command_moved(ranges) else 0.0


def changing_temperature(ranges: Ranges) -> Ends:
    """Lowest and highest temperature (deg C), if it changed in the recordings or since the model was identified.

    Raises:
        Untestable: without a temperature, or if it changed by less than 2 K, and by less than 5 K since.
    """
    if ranges.temperature is None:
        raise Untestable("no temperature was recorded")
    low, high = ranges.temperature
    if not (temperature_moved(ranges) or _changes_temperature(ranges.temperature)):
        raise Untestable(f"the temperature changed by only {high - low:.2g} K")
    return temperatures(ranges) or ranges.temperature


def reference_temperatures(ranges: Ranges) -> tuple[float, ...]:
    """Temperatures at which the model may hold (deg C), the most probable first: where it was identified, and the ends
    of the recorded range, because a damper may have changed since.

    Raises:
        Untestable: as ``changing_temperature``.
    """
    low, high = changing_temperature(ranges)
    known = low if ranges.model_temperature is None else float(np.mean(ranges.model_temperature))
    return (known,) if temperature_moved(ranges) else (known, low, high)


def with_moved_command(trial: Trial, ranges: Ranges) -> Trial:
    """The trial with what a command says that is not the model's: more than anything in the motion could."""
    if not command_moved(ranges):
        return trial
    words = _moved_words("command", ranges.command, ranges.model_command, "A")
    return replace(trial, prior=_MOVED_COMMAND, because=words)


def with_moved_temperature(trial: Trial, ranges: Ranges) -> Trial:
    """The trial with what a temperature says that is not the model's."""
    if not temperature_moved(ranges):
        return trial
    words = _moved_words("temperature", ranges.temperature, ranges.model_temperature, "deg C")
    return replace(trial, prior=_MOVED_TEMPERATURE, because=words)


def _moved_words(channel: str, here: Ends | None, there: Ends | None, unit: str) -> str:
    return (
        f"The {channel} is {_written(here)} {unit} here, and was {_written(there)} {unit} when the model was "
        "identified: that difference speaks for it, nothing within the recordings does."
    )


def _changes_command(ends: Ends) -> bool:
    low, high = ends
    return high - low > max(_STANDING * max(abs(low), abs(high)), _NOISE)


def _changes_temperature(ends: Ends) -> bool:
    return ends[1] - ends[0] >= _LEAST_CHANGE


def _differs_in_temperature(ends: Ends) -> bool:
    return ends[1] - ends[0] >= _LEAST_DIFFERENCE


def _moved(
    recorded: Ends | None, model: Ends | None, changes: Callable[[Ends], bool], differs: Callable[[Ends], bool]
) -> bool:
    if recorded is None or model is None or changes(recorded):
        return False
    return any(differs(gap) for gap in ((model[1], recorded[0]), (recorded[1], model[0])) if gap[0] < gap[1])


def _with(recorded: Ends | None, model: Ends | None) -> Ends | None:
    if recorded is None or model is None:
        return recorded
    return min(recorded[0], model[0]), max(recorded[1], model[1])


def _middle(ends: Ends | None, otherwise: float) -> float:
    return otherwise if ends is None else abs(float(np.mean(ends)))


def _written(ends: Ends | None) -> str:
    low, high = (f"{end:.3g}" for end in ends or (float("nan"),) * 2)
    return low if low == high else f"{low} to {high}"
