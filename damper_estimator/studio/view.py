"""What is on view in the figures: which recording, which stretch of time, what is marked."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.studio.drawn_rows import Mark
from damper_estimator.studio.model_run import ModelRun

MOTIONS = ("velocity", "displacement", "acceleration")
SCALES = {"velocity": 1.0, "displacement": 1e3, "acceleration": 1.0}  # m/s, mm, m/s^2
TRACES = {
    "displacement": ("mm", 1e3), "velocity": ("m/s", 1.0), "acceleration": ("m/s²", 1.0), "command": ("A", 1.0),
    "temperature": ("°C", 1.0), "pressure": ("bar", 1e-5),
}  # fmt: skip
"""What can be drawn below the force, by name in a sample block: unit on the page, and factor from SI."""
TRACE_NAMES = {name: name for name in TRACES} | {"command": "current"}
_MOST_CORNERS = 2000


@dataclass(frozen=True)
class View:
    """What is on view.

    Attributes:
        recording: index.
        start, stop: s since its first sample; None for all.
        mark: what was marked by hand, if anything.
        cursors: up to two times, s since the first sample.
    """

    recording: int = 0
    start: float | None = None
    stop: float | None = None
    mark: Mark | None = None
    cursors: tuple[float, ...] = ()


def parsed_view(data: object, recordings: int) -> View:
    """A view from what the page holds of it.

    Raises:
        InputError: for what no page of ours sends.
    """
    try:
        given = dict(data or {})
        cursors = tuple(_number(value) or 0.0 for value in list(given.get("cursors") or ())[:2])
        ends = _number(given.get("start")), _number(given.get("stop"))
        view = View(int(given.get("recording", 0)), *ends, _mark(given), cursors)
    except (TypeError, ValueError, KeyError):
        raise InputError("the page asked for a view that does not exist; load it again") from None
    if not 0 <= view.recording < recordings:
        raise InputError("the page asked for a recording that is not open; load it again")
    return view


def _number(value: object) -> float | None:
    number = None if value is None else float(value)
    if number is not None and not np.isfinite(number):
        raise ValueError(value)
    return number


def _mark(given: Mapping) -> Mark | None:
    mark = given.get("mark")
    if not mark:
        return None
    x, y = (tuple(_number(v) for v in mark[name]) for name in "xy")
    if mark["figure"] not in ("time", *MOTIONS) or not 1 < len(x) == len(y) < _MOST_CORNERS:
        raise ValueError(mark)
    return Mark(mark["figure"], x, y)


def place(shown: ModelRun, recording: int, motion: str) -> np.ndarray:
    """(n,) a motion in the figures' units."""
    kinematics = shown.traces[recording].measurement.kinematics
    return SCALES[motion] * getattr(kinematics, motion)


def marked(shown: ModelRun, view: View) -> np.ndarray | None:
    """(n,) bool: the samples of the recording that are marked; None where nothing is."""
    if view.mark is None:
        return None
    trace = shown.traces[view.recording]
    x = trace.time - trace.time[0] if view.mark.figure == "time" else place(shown, view.recording, view.mark.figure)
    inside = view.mark.inside(x, trace.measured)
    return inside | view.mark.inside(x, trace.modelled) if view.mark.figure != "time" else inside
