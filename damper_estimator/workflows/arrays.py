"""Turns samples in memory into a part of a test; checks shapes, order and units before any filtering."""

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
# Values that are impossible in the unit, and the probable mistake.
_MOST = {
    "displacement": (1.0, "1 m", "in mm? divide by 1000"),
    "force": (1e6, "1 MN", "in mN? divide by 1000"),
    "temperature": (250.0, "250 deg C", "in K? subtract 273.15"),
}
_LONGEST_STEP = 0.5  # s, median


def part_from_arrays(time: Values, channels: Mapping[str, Arrays], damper: str, name: str) -> Part:
    """A part of a test from samples.

    Args:
        time: (n,) s, rising.
        channels: by role, (n,) or a number, or a mapping of these by damper.
        damper: its name if ``channels`` have no names of dampers.
        name: of the recording.

    Raises:
        InputError: one line that names the array.
    """
    seconds = _time(time, name)
    dampers = _by_damper(channels, damper, name)
    checked = {
        damper_name: {
            role: _channel(f"{name}: {role} of {damper_name}", role, values, seconds.size)
            for role, values in found.items()
        }
        for damper_name, found in dampers.items()
    }
    units = {damper_name: {role: UNITS[role] for role in found} for damper_name, found in checked.items()}
    return Part(Path(name), 1, 1, np.rint(seconds * 1e9).astype(np.int64), checked, units)


def part_from_dataframe(
    frame: pandas.DataFrame, time: str | None, columns: Mapping[str, str], damper: str, name: str
) -> Part:
    """A part of a test from the columns of a data frame.

    Raises:
        InputError: as ``part_from_arrays``, and for unknown roles and missing columns.
    """
    unknown = [role for role in columns if role not in UNITS]
    if unknown:
        raise InputError(f"{name}: unknown roles {', '.join(unknown)}; the roles are {', '.join(UNITS)}")
    column_of = {role: role for role in UNITS if role in frame.columns} | dict(columns)
    missing = [column for column in (*column_of.values(), *([time] if time else [])) if column not in frame.columns]
    if missing:
        columns_there = ", ".join(map(str, frame.columns)) or "none"
        raise InputError(f"{name}: has no column {', '.join(missing)}; it has {columns_there}")
    if "displacement" not in column_of:
        raise InputError(f"{name}: has no column displacement; name it: columns={{'displacement': ...}}")
    instants = frame[time] if time else frame["time"] if "time" in frame.columns else frame.index
    channels = {role: np.asarray(frame[column]) for role, column in column_of.items()}
    return part_from_arrays(np.asarray(instants), channels, damper, name)


def _time(time: Values, name: str) -> np.ndarray:
    seconds = _numbers(f"{name}: time", time)
    if seconds.ndim != 1 or seconds.size < 2:
        raise InputError(f"{name}: time has shape {seconds.shape}; give one array (n,) of at least two samples in s")
    if not np.isfinite(seconds).all():
        raise InputError(f"{name}: time: {_count(~np.isfinite(seconds))} are not finite; omit these samples")
    steps = np.diff(seconds)
    if not (steps > 0.0).all():
        first = int(np.flatnonzero(steps <= 0.0)[0]) + 1
        raise InputError(
            f"{name}: time does not rise at sample {first} ({seconds[first - 1]:.9g} s, then {seconds[first]:.9g} s); "
            "sort the samples and remove duplicates"
        )
    if np.median(steps) > _LONGEST_STEP:
        raise InputError(f"{name}: time has steps of {np.median(steps):.4g} s; give it in s (in ms? divide by 1000)")
    return seconds


def _by_damper(channels: Mapping[str, Arrays], damper: str, name: str) -> dict[str, dict[str, Values]]:
    """Channels by damper and role."""
    displacement = channels["displacement"]
    if not isinstance(displacement, Mapping):
        mixed = [role for role, values in channels.items() if isinstance(values, Mapping)]
        if mixed:
            raise InputError(
                f"{name}: {', '.join(mixed)} given by damper, but displacement is one array; give both in the same way"
            )
        return {damper: {role: values for role, values in channels.items() if not isinstance(values, Mapping)}}
    if not displacement:
        raise InputError(f"{name}: displacement names no damper; give one array for each")
    found: dict[str, dict[str, Values]] = {damper_name: {} for damper_name in displacement}
    for role, values in channels.items():
        if not isinstance(values, Mapping):
            raise InputError(f"{name}: displacement is given by damper, but {role} is not; give both in the same way")
        unknown = [damper_name for damper_name in values if damper_name not in found]
        if unknown:
            raise InputError(f"{name}: {role} of {', '.join(unknown)}, which has no displacement")
        for damper_name, value in values.items():
            found[damper_name][role] = value
    return found


def _channel(label: str, role: str, values: Values, samples: int) -> np.ndarray | float:
    array = _numbers(label, values)
    if array.ndim == 0 and role not in _FAST:
        array = np.full(samples, array)
    if array.shape != (samples,):
        raise InputError(f"{label}: has shape {array.shape}, but time has {samples} samples; give ({samples},)")
    bad = ~np.isfinite(array)
    if bad.any() and (role in _FAST or bad.all()):
        raise InputError(f"{label}: {_count(bad)} are not finite; omit these samples; the gap in time is recognised")
    most, limit, remedy = _MOST.get(role, (np.inf, "", ""))
    largest = float(np.nanquantile(np.abs(array), 0.999))  # a spike says nothing of the unit
    if largest > most:
        raise InputError(f"{label}: reaches {largest:.4g}, more than {limit}; give it in {UNITS[role]} ({remedy})")
    if role == "pressure" and 0.0 < largest < 1000.0:
        raise InputError(f"{label}: stays below {largest:.4g} Pa; give it in Pa (in bar? multiply by 1e5)")
    return array


def _numbers(label: str, values: Values) -> np.ndarray:
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{label}: contains no numbers ({error}); give an array of floats") from error


def _count(bad: np.ndarray) -> str:
    return f"{int(bad.sum())} of {bad.size} values"
