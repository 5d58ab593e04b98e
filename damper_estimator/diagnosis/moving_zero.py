"""A zero of the gauge that moves during a recording: it creeps, jumps or wanders.

No effect of the damper and no correction of the signal map follows it, but beside an error that it makes, what is
missing is seen badly, and what grows with time or temperature is seen where it is not. So effects are looked for
without it: the movement, about its mean, is subtracted from the recordings that they are fitted to and judged on. Read
off whole cycles of the model's error, it must be the same whatever the motion (``validation.drift``). Where it is a
good part of the error, it is a finding itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, dynamic_force, error_of
from damper_estimator.diagnosis.evaluation import HIGH, LOW, Errors, errors, gains
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.result import Finding
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.identification.rows import Rows, force_rms
from damper_estimator.model import DamperModel, Element
from damper_estimator.numbers import number
from damper_estimator.numerics import block_draws
from damper_estimator.signals import Measurement
from damper_estimator.validation.drift import drift
from damper_estimator.validation.error_parts import LEAST_SHARE
from damper_estimator.validation.surrogate import surrogate

_LEAST_KELVIN = 1.0
_MOST_SAID = 3  # recordings, in the evidence
_FOLLOWS = 0.95  # correlation of the movement with the temperature, from which on gas may make it


@dataclass(frozen=True)
class MovingZero:
    """The movement in one recording.

    Attributes:
        recording: its name.
        begin, end: s since the first sample, between which it is largest.
        change: N.
        share: of the squared error about its mean.
        line: (n,) N, the movement about its mean.
    """

    recording: str
    begin: float
    end: float
    change: float
    share: float
    line: np.ndarray

    @property
    def words(self) -> str:
        """When, and by how much."""
        return (
            f"The gauge's zero moves by {number(self.change)} N between {self.begin:.3g} and {self.end:.3g} s of "
            f"{self.recording} ({100.0 * self.share:.0f} % of the squared error about its mean)."
        )

    @property
    def sentence(self) -> str:
        """With what to do."""
        return f"{self.words[:-1]}, which is left out here: tare in between, or cut the recording there. "


def steadied(state: ModelState) -> tuple[ModelState, tuple[MovingZero, ...]]:
    """The state with zeros that do not move in the parts that effects are fitted to and judged on; and how they moved,
    the largest share first.
    """
    moved: list[MovingZero] = []

    def steady(group: Sequence[Measurement]) -> tuple[Measurement, ...]:
        found = [moving_zero(state.model, m) for m in group]
        moved.extend(one for one in found if one is not None)
        return tuple(
            m if one is None else replace(m, force=m.force - one.line) for m, one in zip(group, found, strict=True)
        )

    fit, unseen = steady(state.fit_part), steady(state.unseen_part)
    if not moved:
        return state, ()
    return replace(state, fit_part=fit, unseen_part=unseen), tuple(sorted(moved, key=lambda one: -one.share))


def by_itself(
    state: ModelState, steady: ModelState, moved: Sequence[MovingZero], hidden: Sequence[Hypothesis]
) -> tuple[Finding, Element] | None:
    """The movement as a finding, and its entry; None where it is a small part of the error, or of the force.

    Args:
        state, steady: with the zeros as they were recorded, and without their movement.
        hidden: what the freed zero hides, among it the effect that a zero is.
    """
    zero = next((one.element for one in hidden if one.effect.kind == "channel"), None)
    if not moved or zero is None:
        return None
    with_it, without = (_errors(state.model, each.unseen_part) for each in (state, steady))
    gain = 1.0 - without.square / max(with_it.square, 1e-300)
    force = force_rms(state.unseen_part)
    fall = state.rmse_unseen_n**2 * max(gain, 0.0)
    if gain < limits().gain or np.sqrt(fall) < limits().notable * force:
        return None
    low, high = np.percentile(gains(block_draws(with_it.blocks.size), without, with_it), [LOW, HIGH])
    finding = Finding(
        effect=zero.effect.name,
        phenomenon=zero.effect.phenomenon,
        tied_with=(),
        rmse_before_n=state.rmse_unseen_n,
        rmse_after_n=float(np.sqrt(state.rmse_unseen_n**2 - fall)),
        share_of_explainable_error=gain,
        confidence=limits().form_right,
        gain=gain,
        low=float(low),
        high=float(high),
        evidence=" ".join(one.words for one in moved[:_MOST_SAID]),
        test_to_separate=zero.effect.separate,
        remark="It moves during a recording: no correction of the signal map follows it.",
        parameters=(),
        is_channel=True,
    )
    return finding, zero


def drift_hides_error(model: DamperModel, data: DiagnosisData) -> bool:
    """Whether leaving a straight drift of the zero out takes most of an error that matters, on both parts of the data:
    a movement of the gauge's has been subtracted before (``steadied``), and gas that the oil warms drifts as well.
    """
    drifting = data.with_drift
    parts = (data.fit, drifting.fit), (data.unseen, drifting.unseen)
    least, kept = limits().notable * dynamic_force(drifting.unseen), 1.0 - limits().drift

    def is_hidden(without: Sequence[Rows], with_it: Sequence[Rows]) -> bool:
        error = error_of(model, with_it)
        return error > least and error_of(model, without) ** 2 < kept * error**2

    return all(is_hidden(*pair) for pair in parts)


def _errors(model: DamperModel, group: Sequence[Measurement]) -> Errors:
    """The model's error in band at all judged samples of unseen recordings, in blocks of about a second."""
    error = np.concatenate([_error(model, m)[m.judged] for m in group])
    seconds = sum(float(np.sum(m.kinematics.dt[m.judged])) for m in group)
    return errors(np.sort(np.arange(error.size) % max(int(seconds), 2)), np.zeros(0), error)


def _error(model: DamperModel, m: Measurement) -> np.ndarray:
    """(n,) N, measured less modelled force in band."""
    return m.in_band(m.force) - m.in_band(np.nan_to_num(model.force(m.kinematics.block)))


def moving_zero(model: DamperModel, m: Measurement) -> MovingZero | None:
    """How a recording's zero moves against a model; None where it does not, or hardly matters, or follows the
    temperature, as warm gas does.
    """
    k, judged = m.kinematics, m.judged
    error = _error(model, m)
    if not np.isfinite(error[judged]).all():
        return None
    explained = surrogate([m], [error])
    if explained is None or explained.zeros[0] is None:
        return None
    line = explained.zeros[0].line(k.time, judged)
    share = 1.0 - float(np.var((error - line)[judged]) / max(np.var(error[judged]), 1e-300))
    if share < LEAST_SHARE or _follows(k.temperature[judged], line[judged]):
        return None
    found = drift(m, explained)
    return None if found is None else MovingZero(m.recording, found.begin, found.end, found.change, share, line)


def _follows(temperature: np.ndarray, line: np.ndarray) -> bool:
    known = np.isfinite(temperature)
    if not known.any() or np.ptp(temperature[known]) < _LEAST_KELVIN:
        return False
    return abs(float(np.corrcoef(temperature[known], line[known])[0, 1])) > _FOLLOWS
