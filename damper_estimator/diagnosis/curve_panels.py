"""The variables over which the atlas draws what a model lacks: functions of one, times another."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from damper_estimator.diagnosis.atlas_terms import PLAYS, Columns, View, opening
from damper_estimator.effects.slow_channels import command_moved, temperature_moved
from damper_estimator.effects.trial import Ranges
from damper_estimator.numerics import COARSE_SHARES, FINE_SHARES, hats, play, speed_knots

_MIDDLE_SHARES = (0.05, 0.15, 0.3, 0.5, 1.0)  # of the highest speed: knots of the coefficient of acceleration
_PLACES = 8  # knots over the driven stroke
_SLOW = 0.1  # of the highest speed: the curve over velocity is drawn relative to its mean below
_LONGEST = 0.5  # of the stroke: over a longer way a play is hardly told from a spring


@dataclass(frozen=True)
class Panel:
    """A curve to be found, by the force that goes with each of its points.

    Attributes:
        name: for JSON and pages.
        at: (k,) points of its variable as they were recorded; straight lines connect them.
        shape: in one recording, per point the column (n,) that goes with a curve of 1 there and 0 at the others.
        mean: (k,) weights of the mean that is subtracted from the curve; zeros where none is.
        times: (n,) what the curve is multiplied by; None where it is the force itself.
        is_slow: whether the factor is a temperature or a command.
        is_memory: whether it depends on what came before. Such a curve imitates others in part, so that it counts only
            by what it explains beyond them, as in the form-free tests.
    """

    name: str
    at: np.ndarray
    shape: Callable[[View], Columns]
    mean: np.ndarray
    times: Callable[[View], np.ndarray] | None = None
    is_slow: bool = False
    is_memory: bool = False

    def columns(self, view: View) -> Columns:
        """The shapes times the factor, (n,) each."""
        shape = self.shape(view)
        if self.times is None:
            return shape
        factor = self.times(view)
        return [column * factor for column in shape]

    def about(self, seen: Sequence[View], weight: Callable[[View], np.ndarray]) -> "Panel":
        """The curve relative to its mean over all samples, by the weight (n,) of each."""
        sums = sum(np.array(self.shape(view)) @ weight(view) for view in seen)
        return replace(self, mean=sums / max(float(sums.sum()), 1e-300))


def panels_of(fit: Sequence[View], unseen: Sequence[View], ranges: Ranges) -> list[Panel]:
    """All curves that these recordings can show.

    The force at rest cannot be told from the gauge's zero, nor a factor on the whole force from a change over velocity:
    curves of these are drawn about a mean. A temperature or command counts from where the model was identified, so
    that the curve over velocity is the change there.
    """
    fine, middle, coarse = (
        speed_knots(ranges.speed, shares) for shares in (FINE_SHARES, _MIDDLE_SHARES, COARSE_SHARES)
    )
    found = [
        _over_velocity("velocity", fine).about(fit, partial(_near_rest, _SLOW * ranges.speed)),
        _over_travel("displacement", ranges).about(fit, lambda view: np.ones(view.x.size)),
        _over_travel("position", ranges, lambda view: view.force).about(fit, lambda view: view.force**2),
        _over_velocity("acceleration", middle, lambda view: view.a),
    ]
    for name, ends, identified, moved in (
        ("temperature", ranges.temperature, ranges.model_temperature, temperature_moved(ranges)),
        ("command", ranges.command, ranges.model_command, command_moved(ranges)),
    ):
        # Where it moved since the identification, but stands still here, the curve over velocity shows what it does.
        if not moved and all(getattr(view, name) is not None for view in (*fit, *unseen)):
            zero = _zero(np.concatenate([_slow(name, view) for view in fit]), ends, identified)
            found.append(replace(_over_velocity(name, coarse, partial(_beyond, name, zero)), is_slow=True))
    history = _over_velocity("history", coarse, lambda view: opening(view) - 0.5)
    return [*found, *(replace(panel, is_memory=True) for panel in (history, *_over_way(ranges)))]


def _over_velocity(name: str, knots: np.ndarray, times: Callable[[View], np.ndarray] | None = None) -> Panel:
    return Panel(name, knots, lambda view: hats(view.v, knots), np.zeros(knots.size), times)


def _over_travel(name: str, ranges: Ranges, times: Callable[[View], np.ndarray] | None = None) -> Panel:
    places = np.linspace(-0.5, 0.5, _PLACES) * ranges.stroke
    return Panel(name, places + ranges.middle, lambda view: hats(view.x, places), np.zeros(_PLACES), times)


def _over_way(ranges: Ranges) -> list[Panel]:
    """The force in the direction of motion over the way (m) since a reversal after a long way, less that after a long
    way in the new direction, which belongs to the curve over velocity.

    A play of half width w then gives min(s/w, 2) - 2 over the way s, a straight line up to s = 2 w. So plays of several
    widths, which remember all earlier reversals, make a curve of straight lines between these points.
    """
    widths = np.array([width for width in PLAYS if 2.0 * width <= _LONGEST * ranges.stroke])
    if not widths.size:
        return []
    factors = np.linalg.inv(np.minimum(2.0 * widths[:, None] / widths, 2.0))
    rest = FINE_SHARES[0] * ranges.speed

    def shape(view: View) -> Columns:
        direction = np.clip(view.v / rest, -1.0, 1.0)  # as the curve over velocity can show it
        columns = factors.T @ [play(view.x, view.dt, width) - direction for width in widths]
        return [-columns.sum(axis=0), *columns]

    return [Panel("memory", np.array([0.0, *2.0 * widths]), shape, np.array([*np.zeros(widths.size), 1.0]))]


def _near_rest(speed: float, view: View) -> np.ndarray:
    return (np.abs(view.v) < speed).astype(float)


def _slow(name: str, view: View) -> np.ndarray:
    """(n,) a slow variable in deg C or A."""
    if name == "command":
        return view.command * max(abs(end) for end in view.ranges.command)
    low, high = view.ranges.temperature
    return 0.5 * (low + high + view.temperature * (high - low))


def _beyond(name: str, zero: float, view: View) -> np.ndarray:
    return _slow(name, view) - zero


def _zero(values: np.ndarray, ends: tuple[float, float], identified: tuple[float, float] | None) -> float:
    """Middle of what the model was identified at, as far as that was driven; the mean if unknown."""
    known = identified is not None and np.isfinite(identified).all()
    return float(np.clip(np.mean(identified) if known else values.mean(), *ends))
