"""A free curve of velocity in place of a model's curves, which may be too stiff for the damper.

Every effect is judged by what it explains beyond the curve. Where the curve itself is wrong, a straight line for a
digressive valve, effects would make up for its shape: that damper seems to have oil, play or a valve that it has not.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.apply_finding import ModelState, identified
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.effects.discovery import all_effects
from damper_estimator.identification.knots import with_placed_knots
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import labels, new_element, walk
from damper_estimator.signals import Measurement

_CONTAINED = 0.001  # of the squared force about its mean: a source of which more is left is no curve of velocity
_ROWS = 20000  # that are enough to see this


@dataclass(frozen=True)
class FreeCurve:
    """A model with a free curve, identified.

    Attributes:
        state: the model on its recordings.
        effect: name of the curve.
        replaced: labels of the entries that it contains and replaces; none where it was added beside all.
    """

    state: ModelState
    effect: str
    replaced: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """What it would change, for a diagnosis of the model without it."""
        return (
            f" But the model's curve is too stiff: {self.effect}{in_place_of(self.replaced)} leaves "
            f"{self.state.rmse_unseen_n:.3g} N; improve puts it in first."
        )

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {"effect": self.effect, "replaces": list(self.replaced), "rmse_unseen_n": self.state.rmse_unseen_n}


def in_place_of(replaced: Sequence[str]) -> str:
    """What an entry of a model took the place of, in words to follow its name; "" for nothing."""
    return f" in place of {' and '.join(replaced)}" if replaced else ""


def with_free_curve(state: ModelState) -> FreeCurve | None:
    """The model with a free curve; None where it has one, or where that explains less of the unseen error than an
    effect that is missing has to.
    """
    model = state.model
    if any(element.effect.velocity_axes for element in walk(model.effects)):
        return None
    free = next(effect for effect in all_effects().values() if effect.is_free_curve)
    curve = _placed(new_element(free, model.effects, {}), model, state.fit_part)
    contained = dict(_contained(model, curve, state.fit_part[0]))
    if contained:
        values = np.sum(list(contained.values()), axis=0)
        changed = model.with_instead(list(contained), curve.with_values({"force": tuple(values.tolist())}))
    else:
        changed = model.with_missing(curve)
    after = state.with_model(identified(state, changed))
    most = np.sqrt(1.0 - limits().gain) * state.rmse_unseen_n
    return FreeCurve(after, free.name, tuple(contained)) if after.rmse_unseen_n <= most else None


def _placed(curve: Element, model: DamperModel, measurements: Sequence[Measurement]) -> Element:
    """With its knots over the recordings."""
    return with_placed_knots(replace(model, effects=(curve,)), measurements).effects[0]


def _contained(model: DamperModel, curve: Element, measurement: Measurement) -> Iterator[tuple[str, np.ndarray]]:
    """Label of every source beside which the curve would be the same force twice, and that force at the knots."""
    block = measurement.kinematics.block
    rows = slice(None, None, max(1, block.shape[1] // _ROWS))
    unit = np.eye(len(curve.settings["velocity"]))
    columns = [_alone(curve.with_values({"force": tuple(one)}), model, block)[rows] for one in unit]
    basis = np.column_stack(columns)
    beside = model.springs[-1].path if model.springs else model.effects
    for label, element in labels(model.effects):
        if element.effect.kind != "source" or not any(element is one for one in beside):
            continue
        force = _alone(element, model, block)[rows]
        usable = np.isfinite(force) & np.isfinite(basis).all(axis=1)
        if not force[usable].any():
            continue
        at_knots = np.linalg.lstsq(basis[usable], force[usable], rcond=None)[0]
        left = np.sum((force[usable] - basis[usable] @ at_knots) ** 2)
        moving = np.sum((force[usable] - force[usable].mean()) ** 2)
        if left <= _CONTAINED * moving or np.ptp(force[usable]) == 0.0:
            yield label, at_knots


def _alone(element: Element, model: DamperModel, block: np.ndarray) -> np.ndarray:
    return replace(model, effects=(element,)).force(block)
