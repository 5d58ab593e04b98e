"""The terms of the atlas: linear, form-free ways in which a damper's force may differ from a model's.

Effects say in which tests they show. Each test is a family of columns over one recording, for example hat functions of
velocity (a change of the curve), the same times temperature (the curve depends on temperature), or acceleration times
hat functions of velocity. None of them assumes the form of an effect, so a phenomenon whose real form is in no library
still shows in its test.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.diagnosis_data import slope_of
from damper_estimator.effects.slow_channels import commands, temperatures
from damper_estimator.effects.trial import Ranges
from damper_estimator.identification.rows import Rows
from damper_estimator.model import DamperModel
from damper_estimator.numerics import COARSE_SHARES, FINE_SHARES, hats, lagging, play, speed_knots
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, DT, TEMPERATURE, A, V, X

_OPENINGS = (0.15, 0.3, 0.5, 0.7)  # of the driven speed, at which a valve may open
_PLACES = 8  # knots over the driven stroke
_STOPS = 0.75  # of the half stroke: beyond, an end stop may be touched
_PLAYS, _LONG_PLAYS = (1e-4, 4e-4), (1.5e-3, 5e-3)  # m, half widths of the travel before sliding, and longer ones
PLAYS = (*_PLAYS, *_LONG_PLAYS)
_STEPS = (0.01, 0.05)  # of the driven speed: widths of a step at rest
_LEAST_KELVIN = 1.0
_LEAST_COMMAND = 0.02  # A: less than this is a standing current
_LOOPS = (0.05, 0.2)  # of the largest command: half widths of the field's hysteresis
_FIELD_LAGS = (0.02, 0.1)  # s

Columns = list[np.ndarray]


@dataclass(frozen=True)
class View:
    """One recording as the tests see it; all arrays (n,), SI units.

    Attributes:
        x, v, a, dt: motion, with ``x`` about the middle of the driven stroke.
        temperature: between -1 and 1 over what the fitted recordings hold, from where the model was identified on if it
            moved from there; None where it does not vary.
        command: over its largest value, in the same way; None if it is constant.
        force: of the model, without its mean.
        slope: dF/dv of the model.
        force_rate: dF/dt of the model, N/s.
        ranges: what the fitted recordings drive.
    """

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    dt: np.ndarray
    temperature: np.ndarray | None
    command: np.ndarray | None
    force: np.ndarray
    slope: np.ndarray
    force_rate: np.ndarray
    ranges: Ranges


@dataclass(frozen=True)
class Test:
    """A form-free test.

    Attributes:
        name: for tables and pages.
        contains: names of tests whose columns this one can imitate.
        columns: of one recording; None where the recording cannot show it.
        shows: on which variable the error depends, in words.
    """

    name: str
    contains: tuple[str, ...]
    columns: Callable[[View], Columns | None]
    shows: str


def views(model: DamperModel, rows: Sequence[Rows], ranges: Ranges) -> list[View]:
    """The recordings of some rows as the tests see them."""
    return [view_of(model, one.measurement, ranges) for one in rows]


def view_of(model: DamperModel, measurement: Measurement, ranges: Ranges) -> View:
    """A recording as the tests see it."""
    block = measurement.kinematics.block
    force = np.nan_to_num(model.force(block))
    dt = block[DT]
    change = np.diff(force, prepend=force[:1])
    rate = np.where(dt > 0.0, change / np.where(dt > 0.0, dt, 1.0), 0.0)
    return View(
        x=block[X] - ranges.middle,
        v=block[V],
        a=block[A],
        dt=dt,
        temperature=_varying(block[TEMPERATURE], temperatures(ranges), _LEAST_KELVIN),
        command=_command(block[COMMAND], commands(ranges)),
        force=force - force.mean(),
        slope=slope_of(model, block),
        force_rate=rate,
        ranges=ranges,
    )


def opening(view: View) -> np.ndarray:
    """(n,) 1 where the speed rises, as valves open, and 0 where it falls."""
    return (view.v * view.a > 0.0).astype(float)


def _varying(values: np.ndarray, ends: tuple[float, float] | None, least: float) -> np.ndarray | None:
    """(n,) a slow variable between -1 and 1 over its range on the fitted recordings; None where that is too small."""
    if ends is None or ends[1] - ends[0] < least or not np.isfinite(values).any():
        return None
    return (2.0 * _without_gaps(values) - ends[0] - ends[1]) / (ends[1] - ends[0])


def _without_gaps(values: np.ndarray) -> np.ndarray:
    """(n,) with the first known value where none is known: a channel may begin later than its recording."""
    finite = np.isfinite(values)
    return np.where(finite, values, values[np.argmax(finite)])


def _command(values: np.ndarray, ends: tuple[float, float] | None) -> np.ndarray | None:
    """(n,) the command over its largest value; None if it is constant."""
    if _varying(values, ends, _LEAST_COMMAND) is None:
        return None
    return _without_gaps(values) / max(abs(ends[0]), abs(ends[1]))


def _curve(view: View) -> Columns:
    return hats(view.v, speed_knots(view.ranges.speed, FINE_SHARES))


def _coarse(view: View) -> Columns:
    return hats(view.v, speed_knots(view.ranges.speed, COARSE_SHARES))


def _times(columns: Columns, *factors: np.ndarray) -> Columns:
    return [column * factor for factor in factors for column in columns]


def _step(view: View) -> Columns:
    return [np.tanh(view.v / (share * view.ranges.speed)) for share in _STEPS]


def _plays(view: View, widths: Sequence[float]) -> Columns:
    return [play(view.x, view.dt, width) for width in widths]


def _friction(view: View) -> Columns:
    return [*_step(view), *_plays(view, _PLAYS)]


def _memory(view: View) -> Columns:
    return [*_friction(view), *_plays(view, _LONG_PLAYS)]


def _beyond(view: View) -> Columns:
    openings = [share * view.ranges.speed for share in _OPENINGS]
    return [np.maximum(sign * view.v - opening, 0.0) * sign for opening in openings for sign in (1.0, -1.0)]


def _over_speed(view: View, speed: np.ndarray) -> Columns:
    return hats(speed, view.ranges.speed * np.array([0.0, *FINE_SHARES]))


def _even(view: View) -> Columns:
    return _over_speed(view, np.abs(view.v))


def _rebound(view: View) -> Columns:
    """A change of one direction, which beside a free zero of the gauge need not be even at all."""
    return _over_speed(view, np.maximum(view.v, 0.0))


def _compression(view: View) -> Columns:
    return _over_speed(view, np.maximum(-view.v, 0.0))


def _places(view: View) -> np.ndarray:
    half = 0.5 * view.ranges.stroke
    return np.linspace(-half, half, _PLACES)


def _over_travel(view: View) -> Columns:
    return hats(view.x, _places(view))


def _spring(view: View) -> Columns:
    return [view.x]


def _stops(view: View) -> Columns:
    half = 0.5 * view.ranges.stroke
    past = [np.maximum(sign * view.x - _STOPS * half, 0.0) * sign for sign in (1.0, -1.0)]
    return [*past, *(column * np.abs(column) for column in past)]


def _position(view: View) -> Columns:
    half = 0.5 * view.ranges.stroke
    share = view.x / half
    curve = _coarse(view)
    middle = np.exp(-((2.0 * share) ** 2))
    return _times(curve, share, share**2, middle)


def _warm(view: View) -> Columns | None:
    if view.temperature is None:
        return None
    warm = view.temperature
    return [*_coarse(view), *_times(_coarse(view), warm, warm**2), *_times([view.force], warm)]


def _current(view: View) -> Columns | None:
    if view.command is None:
        return None
    memory = _plays(view, (*_PLAYS, _LONG_PLAYS[0]))
    return _times([*_coarse(view), *_step(view), *memory], view.command, view.command**2)


def _earlier_commands(view: View) -> Columns | None:
    """What the field keeps of the commands before, for a field that follows by a way of the command, or in time."""
    command, dt = view.command, view.dt
    if command is None:
        return None
    kept = [width * play(command, dt, width) for width in _LOOPS]
    late = [command - lagging(command, dt, constant) for constant in _FIELD_LAGS]
    return _times([*_step(view), view.v / view.ranges.speed], *kept, *late)


def _mass(view: View) -> Columns:
    return [view.a]


def _shift(view: View) -> Columns:
    return [view.force_rate]


def _series(view: View) -> Columns:
    yielding = view.slope * view.force_rate
    return [np.where(view.force > 0.0, yielding, 0.0), np.where(view.force > 0.0, 0.0, yielding)]


def _valve(view: View) -> Columns:
    speeds = [np.abs(view.v) > share * view.ranges.speed for share in _OPENINGS[:3]]
    return [np.where(above & (sign * view.v > 0.0), view.a, 0.0) for above in speeds for sign in (1.0, -1.0)]


def _lags(view: View) -> Columns:
    return _times(_coarse(view), view.a)


def _history(view: View) -> Columns:
    """Acceleration over velocity, different on opening and on closing, with the force that is lost meanwhile."""
    rising = opening(view)
    curve = _coarse(view)
    return [*_times(curve, view.a * rising, view.a * (1.0 - rising)), *_times(curve, rising)]


_CURVES = ("friction step", "blow-off", "even", "rebound", "compression")
_ELASTIC = ("mass", "shift", "series", "valve")

TESTS = (
    Test("curve", _CURVES, _curve, "velocity alone: another curve"),
    Test("friction step", (), _friction, "the direction of motion"),
    Test("memory", ("friction step",), _memory, "the last millimetres of the motion"),
    Test("blow-off", (), _beyond, "velocity beyond an opening speed"),
    Test("even", (), _even, "speed, alike in both directions"),
    Test("rebound", (), _rebound, "velocity in rebound only"),
    Test("compression", (), _compression, "velocity in compression only"),
    Test("temperature", ("curve",), _warm, "velocity and temperature"),
    Test("current", (), _current, "velocity and command"),
    Test("earlier commands", (), _earlier_commands, "velocity and the commands before"),
    Test("position", ("spring", "travel", "stops", "curve"), _position, "velocity and position"),
    Test("travel", ("spring", "stops"), _over_travel, "displacement alone"),
    Test("spring", (), _spring, "displacement alone, in a straight line"),
    Test("stops", (), _stops, "displacement near the ends of the stroke"),
    Test("mass", (), _mass, "acceleration, alike at all velocities"),
    Test("shift", (), _shift, "the rate of the force"),
    Test("series", (), _series, "the rate of the force times the slope of the curve"),
    Test("valve", ("mass", "shift", "series"), _valve, "acceleration above a speed only"),
    Test("lags", _ELASTIC, _lags, "acceleration, by velocity"),
    Test(
        "history",
        (*_ELASTIC, "lags", "curve", "friction step", "memory"),
        _history,
        "acceleration and velocity, otherwise on opening than on closing",
    ),
)
