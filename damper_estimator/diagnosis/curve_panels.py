"""The variables over which the atlas draws what a model lacks: hat functions of one, times another."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from damper_estimator.diagnosis.atlas_terms import Columns, View
from damper_estimator.effects.trial import Ranges
from damper_estimator.numerics import COARSE_SHARES, FINE_SHARES, hats, speed_knots

_MIDDLE_SHARES = (0.05, 0.15, 0.3, 0.5, 1.0)  # of the highest speed: knots of the coefficient of acceleration
_PLACES = 8  # knots over the driven stroke
_SLOW = 0.1  # of the highest speed: the curve over velocity is drawn relative to its mean below


@dataclass(frozen=True)
class Panel:
    """A curve to be found, as coefficients of hat functions.

    Attributes:
        name: for JSON and pages.
        knots: (k,) of its variable, displacement about the middle of the stroke.
        at: (k,) the same as they were recorded.
        over: its variable (n,) in one recording.
        times: (n,) what the curve is multiplied by; None where it is the force itself.
        reference: (n,) weight of each sample in the mean that the curve is drawn relative to; None where the data
            determine the mean.
        is_slow: whether the factor is a temperature or a command.
    """

    name: str
    knots: np.ndarray
    at: np.ndarray
    over: Callable[[View], np.ndarray]
    times: Callable[[View], np.ndarray] | None = None
    reference: Callable[[View], np.ndarray] | None = None
    is_slow: bool = False

    def columns(self, view: View) -> Columns:
        """The hat functions times the factor, (n,) each."""
        shape = hats(self.over(view), self.knots)
        if self.times is None:
            return shape
        factor = self.times(view)
        return [hat * factor for hat in shape]

    def mean(self, seen: Sequence[View]) -> np.ndarray:
        """(k,) weights of the mean that is subtracted from the curve; zeros where none is."""
        if self.reference is None:
            return np.zeros(self.knots.size)
        sums = sum(np.array(hats(self.over(view), self.knots)) @ self.reference(view) for view in seen)
        return sums / max(float(sums.sum()), 1e-300)


def panels_of(fit: Sequence[View], unseen: Sequence[View], ranges: Ranges) -> list[Panel]:
    """All curves that these recordings can show.

    The force at rest cannot be told from the gauge's zero, nor a factor on the whole force from a change over velocity:
    curves of these are drawn about a mean. A temperature or command counts from where the model was identified, so
    that the curve over velocity is the change there.
    """
    fine, middle, coarse = (
        speed_knots(ranges.speed, shares) for shares in (FINE_SHARES, _MIDDLE_SHARES, COARSE_SHARES)
    )
    places = np.linspace(-0.5, 0.5, _PLACES) * ranges.stroke
    recorded = places + ranges.middle
    found = [
        Panel("velocity", fine, fine, _velocity, None, partial(_near_rest, _SLOW * ranges.speed)),
        Panel("displacement", places, recorded, _displacement, None, lambda view: np.ones(view.x.size)),
        Panel("position", places, recorded, _displacement, lambda view: view.force, lambda view: view.force**2),
        Panel("acceleration", middle, middle, _velocity, lambda view: view.a),
    ]
    for name, ends, identified in (
        ("temperature", ranges.temperature, ranges.model_temperature),
        ("command", ranges.command, ranges.model_command),
    ):
        if all(getattr(view, name) is not None for view in (*fit, *unseen)):
            zero = _zero(np.concatenate([_slow(name, view) for view in fit]), ends, identified)
            found.append(Panel(name, coarse, coarse, _velocity, partial(_beyond, name, zero), is_slow=True))
    return found


def _velocity(view: View) -> np.ndarray:
    return view.v


def _displacement(view: View) -> np.ndarray:
    return view.x


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


def _zero(values: np.ndarray, ends: tuple[float, float], identified: float | None) -> float:
    """Where the model was identified, as far as that was driven; the mean if unknown."""
    known = identified is not None and np.isfinite(identified)
    return float(np.clip(identified if known else values.mean(), *ends))
