"""Trials of effects that follow the command or the temperature: what of it changes, and where the model holds.

A channel that stands still in the recordings explains nothing in them. It may still differ from where the model was
identified, by more than it changes in them, as when a damper is driven at one current after the other, or warm after it
was cold; then that difference speaks for the effect.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from damper_estimator.effects.contract import Setting
from damper_estimator.effects.trial import Ranges, Trial, Untestable

Ends = tuple[float, float]

REFERENCE = Setting("reference", "deg C", 40.0, "temperature at which the model holds", lower=-60.0, upper=200.0)

_STANDING = 0.05  # of the largest command: a smaller change counts as constant
_NOISE = 0.02  # A (or V): so does the noise of a current that is switched off
_LEAST_CHANGE = 2.0  # K
_LEAST_DIFFERENCE = 5.0  # K, between recordings, in which other causes differ as well
_MOVED_COMMAND = 50.0  # prior: three of four recorded commands act, the rest shares the remaining quarter
_MOVED_TEMPERATURE = 0.5  # prior per kelvin: it acts on all dampers, seldom by much where the difference is small


def command_moved(ranges: Ranges) -> bool:
    """Whether the command is farther from where the model was identified than it changes in the recordings."""
    return _command_move(ranges) is not None


def temperature_moved(ranges: Ranges) -> bool:
    """Whether the temperature is farther from where the model was identified than it changes in the recordings."""
    return _temperature_move(ranges) is not None


def commands(ranges: Ranges) -> Ends | None:
    """Lowest and highest command, A, from that of the model on where it moved; None where not recorded."""
    move = _command_move(ranges)
    return ranges.command if move is None else _across(*move)


def temperatures(ranges: Ranges) -> Ends | None:
    """Lowest and highest temperature, deg C, from that of the model on where it moved; None where not recorded."""
    move = _temperature_move(ranges)
    return ranges.temperature if move is None else _across(*move)


def changing_command(ranges: Ranges) -> Ends:
    """Lowest and highest command (A).

    Raises:
        Untestable: without a command, or with a constant one, which explains nothing.
    """
    return _changing(ranges.command)


def moved_command(ranges: Ranges) -> Ends:
    """Lowest and highest command (A), if it changed in the recordings or since the model was identified.

    Raises:
        Untestable: as ``changing_command``.
    """
    return _changing(commands(ranges))


def reference_commands(ranges: Ranges) -> tuple[float, ...]:
    """Sizes of the command at which the model may hold (A), the most probable first: where it was identified, and large
    and small recorded ones.

    Raises:
        Untestable: as ``moved_command``.
    """
    most = max(abs(value) for value in moved_command(ranges))
    known = 0.0 if ranges.model_command is None else _size(ranges.model_command)
    if command_moved(ranges):
        return (known,)
    return (known if known > _STANDING * most else most, most, 0.25 * most)


def zero_command(ranges: Ranges) -> float:
    """Size of the command (A) at which an effect that grows from zero adds nothing: 0, or where the model was
    identified, if the command has moved from there.
    """
    move = _command_move(ranges)
    return 0.0 if move is None else _size(move[1])


def changing_temperature(ranges: Ranges) -> Ends:
    """Lowest and highest temperature (deg C), if it changed in the recordings or since the model was identified.

    Raises:
        Untestable: without a temperature, or if it changed by less than 2 K, and by less than 5 K since.
    """
    ends = temperatures(ranges)
    if ends is None:
        raise Untestable("no temperature was recorded")
    low, high = ends
    if not _changes_temperature(ends):
        raise Untestable(f"the temperature changed by only {high - low:.2g} K")
    return ends


def keeps_its_temperature(ranges: Ranges) -> bool:
    """Whether a thermometer shows that the damper was as warm throughout the recordings."""
    return ranges.temperature is not None and not _changes_temperature(ranges.temperature)


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
    move = _command_move(ranges)
    return trial if move is None else replace(trial, prior=_MOVED_COMMAND, because=_words("command", "A", *move))


def with_moved_temperature(trial: Trial, ranges: Ranges) -> Trial:
    """The trial with what a temperature says that is not the model's."""
    move = _temperature_move(ranges)
    if move is None:
        return trial
    here, there = move
    low, high = _between(here, there)
    prior = max(1.0, _MOVED_TEMPERATURE * (high - low))
    return replace(trial, prior=prior, because=_words("temperature", "deg C", here, there))


def _command_move(ranges: Ranges) -> tuple[Ends, Ends] | None:
    return _move(ranges.command, ranges.model_command, _changes_command)


def _temperature_move(ranges: Ranges) -> tuple[Ends, Ends] | None:
    return _move(ranges.temperature, ranges.model_temperature, _differs_in_temperature)


def _move(recorded: Ends | None, model: Ends | None, differs: Callable[[Ends], bool]) -> tuple[Ends, Ends] | None:
    """Where a channel is now and where it was, if the gap between both counts, and is larger than the changes now; else
    None.
    """
    if recorded is None or model is None:
        return None
    low, high = _between(recorded, model)
    is_apart = high - low > recorded[1] - recorded[0]
    return (recorded, model) if is_apart and differs((low, high)) else None


def _between(one: Ends, other: Ends) -> Ends:
    """The gap between two ranges; its ends are in the wrong order where they overlap."""
    return min(one[1], other[1]), max(one[0], other[0])


def _changing(ends: Ends | None) -> Ends:
    if ends is None:
        raise Untestable("no command was recorded")
    if not _changes_command(ends):
        raise Untestable("the command did not change")
    return ends


def _changes_command(ends: Ends) -> bool:
    low, high = ends
    return high - low > max(_STANDING * max(abs(low), abs(high)), _NOISE)


def _changes_temperature(ends: Ends) -> bool:
    return ends[1] - ends[0] >= _LEAST_CHANGE


def _differs_in_temperature(ends: Ends) -> bool:
    return ends[1] - ends[0] >= _LEAST_DIFFERENCE


def _across(one: Ends, other: Ends) -> Ends:
    return min(one[0], other[0]), max(one[1], other[1])


def _size(ends: Ends) -> float:
    return abs(float(np.mean(ends)))


def _words(channel: str, unit: str, here: Ends, there: Ends) -> str:
    return (
        f"The {channel} is {_written(here)} {unit} here, and was {_written(there)} {unit} when the model was "
        "identified: that difference speaks for it, hardly anything within the recordings does."
    )


def _written(ends: Ends) -> str:
    low, high = (f"{end:.3g}" for end in ends)
    return low if low == high else f"{low} to {high}"
