"""Plays a drive file written by ``plan`` on a simulated damper."""

from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from damper_estimator.errors import InputError
from damper_estimator.plant import STEP, Damper, Drive

_COLUMNS = ("time_s", "displacement_m", "current_a")


def played_drive(path: Path, damper: Damper, seed: int) -> Drive:
    """The motion of a drive file at the simulation's step, with its current if it has one.

    Raises:
        InputError: for a file that is not a drive, and for a drive beyond the damper's stroke.
    """
    try:
        with path.open(encoding="utf-8") as stream:
            names = stream.readline().strip().split(",")
            rows = np.loadtxt(stream, delimiter=",", ndmin=2)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the drive.csv that plan wrote") from error
    except ValueError as error:
        raise InputError(f"{path}: is not a table of numbers; give the drive.csv that plan wrote") from error
    if names[:2] != list(_COLUMNS[:2]) or rows.shape[0] < 10 or not (np.diff(rows[:, 0]) > 0.0).all():
        raise InputError(
            f"{path}: needs columns {_COLUMNS[0]} (rising) and {_COLUMNS[1]}; give the drive.csv that plan wrote"
        )
    columns = dict(zip(names, rows.T, strict=True))
    time = np.arange(0.0, columns["time_s"][-1], STEP)
    displacement = CubicSpline(columns["time_s"], columns["displacement_m"])(time)
    geometry = damper.geometry
    low, high = -geometry.compression_stroke, geometry.rebound_stroke
    if not (np.isfinite(displacement).all() and low < displacement.min() and displacement.max() < high):
        raise InputError(
            f"{path}: exceeds the stroke of {damper.name}, {1e3 * low:.0f} to {1e3 * high:.0f} mm; state the damper's "
            "travel in the rig's file"
        )
    current = np.interp(time, columns["time_s"], columns.get("current_a", np.zeros_like(columns["time_s"])))
    return Drive("played", STEP, displacement, current, seed)
