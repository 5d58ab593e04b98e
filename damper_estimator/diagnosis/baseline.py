"""The model as it stands, before an effect is tried: its error, derivatives and form-free tests on both parts.

What a common refit would do is known to first order from the derivatives of the force by the model's parameters. That
is cheap enough for every hypothesis.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from damper_estimator.diagnosis.atlas import Terms, terms
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, force_rows, targets
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.recorded_force import recorded_force_model, rows_with_force
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.effects.contract import Effect
from damper_estimator.identification.rows import Rows
from damper_estimator.model import DamperModel
from damper_estimator.model.element import Element, labels, walk
from damper_estimator.model.wrapping import carries
from damper_estimator.numerics import ROUGH, damped_step, stepped

_DAMPED_FROM = 0.3  # of its size: a parameter that moves further in a first-order refit is damped


@dataclass(frozen=True)
class Baseline:
    """The model as it stands, on both parts of the data.

    Attributes:
        residual_fit, residual_unseen: (r,) rows, modelled less measured.
        base_fit, base_unseen: (r, p) derivatives by the model's parameters, each times the parameter's size.
        found_fit, found_unseen: (r, f) the same by parameters of effects found before.
    """

    model: DamperModel
    data: DiagnosisData
    residual_fit: np.ndarray
    residual_unseen: np.ndarray
    base_fit: np.ndarray
    base_unseen: np.ndarray
    found_fit: np.ndarray
    found_unseen: np.ndarray

    @cached_property
    def recorded(self) -> tuple[DamperModel, DiagnosisData]:
        """The model as one recorded force, with the data that carries it."""
        return self._recorded(())

    @cached_property
    def recorded_inside(self) -> tuple[DamperModel, DiagnosisData]:
        """The same with the motion behind the series springs, where sources act; as ``recorded`` without any."""
        return self._behind(self.model.springs)

    @cached_property
    def recorded_beside_oil(self) -> tuple[DamperModel, DiagnosisData]:
        """The same where forces act that are no pressure differences: the oil's deflection does not move them."""
        carrying = tuple(spring for spring in self.model.springs if carries(spring, True))
        return self.recorded_inside if len(carrying) == len(self.model.springs) else self._behind(carrying)

    def _behind(self, springs: Sequence[Element]) -> tuple[DamperModel, DiagnosisData]:
        return self._recorded(springs) if springs else self.recorded

    def _recorded(self, inside: Sequence[Element]) -> tuple[DamperModel, DiagnosisData]:
        rows = {name: rows_with_force(self.model, getattr(self.data, name), inside) for name in ("fit", "unseen")}
        return recorded_force_model(self.model), replace(self.data, **rows)

    @cached_property
    def tests(self) -> list[Terms]:
        """The form-free tests that the recordings allow."""
        return terms(self.model, self.data)

    @cached_property
    def has_compliance(self) -> bool:
        """Whether there is a compliance in the model, so that running it is slow."""
        return any(element.effect.kind == "series" for element in walk(self.model.effects))

    @cached_property
    def hints(self) -> dict[str, float]:
        """By form-free test, the share of the squared error that it explains on the fitted rows, with the model's
        parameters kept or refitted, whichever is more.
        """
        found: dict[str, float] = {}
        for base in (self.base_fit[:, :0], self.base_fit):
            known = np.hstack([self.found_fit, base])
            before = _left(self.residual_fit, known)
            for one in self.tests:
                gain = 1.0 - _left(self.residual_fit, np.hstack([known, one.fit])) / max(before, 1e-300)
                found[one.test.name] = max(gain, found.get(one.test.name, 0.0))
        return found

    def suggests(self, hypothesis: Hypothesis) -> bool:
        """Whether one of the hypothesis's form-free tests explains enough for it to be tried.

        A compliance changes how all that is behind it shows, so its tests are those of the model's effects as well.
        True without any, and where the tests do not see a large error, as of a chamber that loses its oil to vapour for
        many strokes.
        """
        names = hypothesis.tests
        if hypothesis.effect.kind == "series":
            names = names.union(*(element.effect.tests for element in walk(self.model.effects)))
        hints = [self.hints[name] for name in names if name in self.hints]
        return not hints or max(hints) >= limits().hint or not self.is_seen

    @cached_property
    def is_seen(self) -> bool:
        """Whether a form-free test explains the error, or the error is small."""
        error = np.sqrt(np.mean(self.residual_fit**2))
        is_small = error <= limits().usual * self.data.force_rms
        return is_small or max(self.hints.values(), default=0.0) >= limits().silent_tests

    def for_effect(self, effect: Effect) -> tuple[DamperModel, DiagnosisData]:
        """The model and data on which an effect is tried: what acts behind the model need not run it."""
        # Input and channel effects rewrite the motion or the force of all sources, the new one included.
        untouched = self.has_compliance or all(e.effect.kind not in ("input", "channel") for e in self.model.effects)
        if effect.kind == "source" and untouched:
            return self.recorded_beside_oil if effect.beside_oil else self.recorded_inside
        return self.recorded if effect.kind in ("modifier", "channel") else (self.model, self.data)


def baseline_of(
    model: DamperModel, data: DiagnosisData, found: Sequence[int] = (), base: Sequence[int] | None = None
) -> Baseline:
    """The model on the data.

    Args:
        found: positions in its slots of parameters that are never kept.
        base: positions of those that a refit moves; all others that are free where left out.
    """
    if base is None:
        base = [i for i, slot in enumerate(model.slots) if i not in found and not slot.fixed]
    fit, unseen = force_rows(model, data.fit), force_rows(model, data.unseen)
    return Baseline(
        model,
        data,
        fit - targets(data.fit),
        unseen - targets(data.unseen),
        near_derivatives(model, data.fit, base, fit),
        near_derivatives(model, data.unseen, base, unseen),
        derivatives(model, data.fit, found, fit),
        derivatives(model, data.unseen, found, unseen),
    )


def derivatives(model: DamperModel, rows: Sequence[Rows], slots: Sequence[int], force: np.ndarray) -> np.ndarray:
    """(r, k) derivatives of the force rows by parameters, times the parameters' sizes."""
    vector = np.array([slot.value for slot in model.slots])
    vectors, scales = [], []
    for i in slots:
        slot = model.slots[i]
        size = slot_size(slot)
        changed, step = stepped(vector, i, size, slot.parameter.lower, slot.parameter.upper, ROUGH)
        vectors.append(changed)
        scales.append(size / step)

    def changed_forces(block: np.ndarray) -> Iterator[np.ndarray]:
        return (model.force_at(one, block) for one in vectors)

    changed_rows = [part.of_columns(changed_forces(part.measurement.kinematics.block)) for part in rows]
    return np.nan_to_num((np.concatenate(changed_rows) - force[:, None]) * np.array(scales))


def near_derivatives(model: DamperModel, rows: Sequence[Rows], slots: Sequence[int], force: np.ndarray) -> np.ndarray:
    """(r, k) derivatives by parameters times their sizes; those of a compliance's path as if it were rigid."""
    rigid = model
    while compliances := [label for label, e in labels(rigid.effects) if e.effect.kind == "series"]:
        rigid = rigid.without(compliances[0])
    origin = positions_in(model, rigid)
    if rigid is model or not slots:
        return derivatives(model, rows, slots, force)
    columns = np.zeros((force.size, len(slots)))
    stiff = [k for k, i in enumerate(slots) if i not in origin]
    inner = [k for k, i in enumerate(slots) if i in origin]
    columns[:, stiff] = derivatives(model, rows, [slots[k] for k in stiff], force)
    columns[:, inner] = derivatives(rigid, rows, [origin.index(slots[k]) for k in inner], force_rows(rigid, rows))
    return columns


def positions_in(model: DamperModel, less: DamperModel) -> list[int]:
    """The slot of ``model`` that each slot of ``less`` is, which has fewer of the same entries."""
    entries, remaining = list(walk(model.effects)), list(walk(less.effects))
    slots = {(id(entries[slot.entry]), slot.parameter.name, slot.index): i for i, slot in enumerate(model.slots)}
    return [slots[id(remaining[slot.entry]), slot.parameter.name, slot.index] for slot in less.slots]


def slot_size(slot) -> float:
    """How much of a parameter is much."""
    declared = slot.parameter
    return max(abs(slot.value), abs(declared.default), 1e-3 * min(declared.upper - declared.lower, 1e3))


def _left(residual: np.ndarray, columns: np.ndarray) -> float:
    return float(np.sum(first_order(residual, columns, residual[:0], columns[:0])[0] ** 2))


def first_order(
    residual: np.ndarray, columns: np.ndarray, residual_unseen: np.ndarray, columns_unseen: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (r,) of both parts after a linear refit by ``columns`` (r, k), each in sizes of its parameter.

    A parameter that would move by much more than a share of its size is damped: derivatives are useless beyond.
    """
    if not columns.shape[1]:
        return residual, residual_unseen
    step = damped_step(columns, residual, _DAMPED_FROM)
    return residual + columns @ step, residual_unseen + columns_unseen @ step
