"""Samples that lie in memory as the part of a test: shapes, order and units are checked before anything is filtered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings import Part

if TYPE_CHECKING:
    import pandas

Values = np.ndarray | Sequence[float] | float
Arrays = Values | Mapping[str, Values]
"""The values of one channel, or those of several dampers by name."""

UNITS = {
    "displacement": "m", "force": "N", "command": "A", "temperature": "deg C", "pressure": "Pa",
    "acceleration": "m/s^2",
}  # fmt: skip
_FAST = ("displacement", "force")
# Values that no damper has in the unit, and what they probably are.
_MOST = {
    "displacement": (1.0, "1 m", "in mm? divide by 1000"),
    "force": (1e6, "1 MN", "in mN? divide by 1000"),
    "temperature": (250.0, "250 deg C", "in K? subtract 273.15"),
}
_LONGEST_STEP = 0.5  # s, of most steps


def part_from_arrays(time: Values, channels: Mapping[str, Arrays], damper: str, name: str) -> Part:
    """The part of a test that these samples are.

    Args:
        time: (n,) s, rising.
        channels: by role, (n,) or a number, or these by damper.
        damper: name where ``channels`` name none.
        name: of the recording.

    Raises:
        InputError: one line that names the array.
    """
    seconds = _time(time, name)
    dampers = _by_damper(channels, damper, name)
    checked = {
        own: {role: _channel(f"{name}: {role} of {own}", role, values, seconds.size) for role, values in found.items()}
        for own, found in dampers.items()
    }
    units = {own: {role: UNITS[role] for role in found} for own, found in checked.items()}
    return Part(Path(name), 1, 1, np.rint(seconds * 1e9).astype(np.int64), checked, units)


def part_from_dataframe(
    frame: pandas.DataFrame, time: str | None, columns: Mapping[str, str], damper: str, name: str
) -> Part:
    """The part of a test that a data frame's columns are.

    Raises:
        InputError: as ``part_from_arrays``, for roles that do not exist and for columns that are not there.
    """
    unknown = [role for role in columns if role not in UNITS]
    if unknown:
        raise InputError(f"{name}: unknown roles {', '.join(unknown)}; there are {', '.join(UNITS)}")
    wanted = {role: role for role in UNITS if role in frame.columns} | dict(columns)
    missing = [column for column in (*wanted.values(), *([time] if time else [])) if column not in frame.columns]
    if missing:
        there = ", ".join(map(str, frame.columns)) or "none"
        raise InputError(f"{name}: has no column {', '.join(missing)}; it has {there}")
    if "displacement" not in wanted:
        raise InputError(f"{name}: has no column displacement; name it: columns={{'displacement': ...}}")
    instants = frame[time] if time else frame["time"] if "time" in frame.columns else frame.index
    channels = {role: np.asarray(frame[column]) for role, column in wanted.items()}
    return part_from_arrays(np.asarray(instants), channels, damper, name)


def _time(time: Values, name: str) -> np.ndarray:
    seconds = _numbers(f"{name}: time", time)
    if seconds.ndim != 1 or seconds.size < 2:
        raise InputError(f"{name}: time has shape {seconds.shape}; give one array (n,) of at least two samples in s")
    if not np.isfinite(seconds).all():
        raise InputError(f"{name}: time: {_count(~np.isfinite(seconds))} are not finite; leave these samples out")
    steps = np.diff(seconds)
    if not (steps > 0.0).all():
        first = int(np.flatnonzero(steps <= 0.0)[0]) + 1
        raise InputError(
            f"{name}: time does not rise at sample {first} ({seconds[first - 1]:.9g} s, then {seconds[first]:.9g} s); "
            "sort the samples and leave out doubles"
        )
    if np.median(steps) > _LONGEST_STEP:
        raise InputError(f"{name}: time has steps of {np.median(steps):.4g} s; give it in s (in ms? divide by 1000)")
    return seconds


def _by_damper(channels: Mapping[str, Arrays], damper: str, name: str) -> dict[str, dict[str, Values]]:
    """Channels by damper and role."""
    displacement = channels["displacement"]
    if not isinstance(displacement, Mapping):
        mixed = [role for role, own in channels.items() if isinstance(own, Mapping)]
        if mixed:
            raise InputError(
                f"{name}: {', '.join(mixed)} given by damper, but displacement is one array; give both alike"
            )
        return {damper: {role: own for role, own in channels.items() if not isinstance(own, Mapping)}}
    if not displacement:
        raise InputError(f"{name}: displacement names no damper; give one array for each")
    found: dict[str, dict[str, Values]] = {own: {} for own in displacement}
    for role, values in channels.items():
        if not isinstance(values, Mapping):
            raise InputError(f"{name}: displacement is given by damper, but {role} is not; give both alike")
        unknown = [own for own in values if own not in found]
        if unknown:
            raise InputError(f"{name}: {role} of {', '.join(unknown)}, of which there is no displacement")
        for own, value in values.items():
            found[own][role] = value
    return found


def _channel(what: str, role: str, values: Values, samples: int) -> np.ndarray | float:
    own = _numbers(what, values)
    if own.ndim == 0 and role not in _FAST:
        own = np.full(samples, own)
    if own.shape != (samples,):
        raise InputError(f"{what}: has shape {own.shape}, but time has {samples} samples; give ({samples},)")
    bad = ~np.isfinite(own)
    if bad.any() and (role in _FAST or bad.all()):
        raise InputError(f"{what}: {_count(bad)} are not finite; leave these samples out, a gap in time is noticed")
    most, limit, remedy = _MOST.get(role, (np.inf, "", ""))
    largest = float(np.nanmax(np.abs(own)))
    if largest > most:
        raise InputError(f"{what}: reaches {largest:.4g}, more than {limit}; give it in {UNITS[role]} ({remedy})")
    if role == "pressure" and 0.0 < largest < 1000.0:
        raise InputError(f"{what}: stays below {largest:.4g} Pa; give it in Pa (in bar? multiply by 1e5)")
    return own


def _numbers(what: str, values: Values) -> np.ndarray:
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what}: holds no numbers ({error}); give an array of floats") from error


def _count(bad: np.ndarray) -> str:
    return f"{int(bad.sum())} of {bad.size} values"
