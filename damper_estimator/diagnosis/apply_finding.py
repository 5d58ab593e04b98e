"""Puts a finding into the model, or into the signal map, and says what that gives on unseen data.

``diagnose`` promises these numbers, ``improve`` and the studio deliver them: they all come from here.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from damper_estimator.diagnosis.correction import corrected, corrected_signals
from damper_estimator.diagnosis.hypotheses import Region, are_themselves, limits_in
from damper_estimator.diagnosis.informative import informative
from damper_estimator.diagnosis.local_fit import locally_fitted
from damper_estimator.diagnosis.misfit import has_grown
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.errors import InputError
from damper_estimator.identification import fit as identify
from damper_estimator.identification import pooled_error
from damper_estimator.identification.rows import force_rms
from damper_estimator.model import DamperModel, Element
from damper_estimator.signals import Measurement

_DELIVERED = 0.5  # of what a finding promises
_FULFILLED = 0.9  # of it: with less, the other way to identify is tried as well


@dataclass(frozen=True)
class ModelState:
    """A model with its recordings, between two steps.

    Attributes:
        fit, unseen: recordings, read with the signal map as it is now; errors are those of the whole.
        fit_part, unseen_part: what effects are fitted to and judged on: their informative stretches.
        added: effects that were added, in order, with the regions where they are what they represent.
        note: how the model was identified, where that is not the ordinary way.
    """

    model: DamperModel
    fit: tuple[Measurement, ...]
    unseen: tuple[Measurement, ...]
    fit_part: tuple[Measurement, ...]
    unseen_part: tuple[Measurement, ...]
    rmse_fit_n: float
    rmse_unseen_n: float
    added: Mapping[str, Region] = field(default_factory=dict)
    note: str = ""

    @cached_property
    def is_identified_here(self) -> bool:
        """Whether the model was identified on one of these recordings, and errs there as it did then: then the question
        is what it lacks, not what changed. A part that it was not identified on says how well it predicts.
        """
        bags = self.model.fit.get("bags")
        names = {Path(str(bag)).name for bag in bags} if isinstance(bags, (list, tuple)) else set()
        groups = ([m for m in group if Path(m.recording).name in names] for group in (self.fit, self.unseen))
        same = next((group for group in groups if group), None)
        if same is None:
            return False
        return not has_grown(self.model, pooled_error(self.model, same)[0] / force_rms(same), if_unknown=False)

    def with_model(self, model: DamperModel, note: str = "") -> "ModelState":
        """Another model on the same recordings; one without a finite force has an infinite error."""
        with np.errstate(over="ignore", invalid="ignore"):
            errors = [pooled_error(model, group)[0] for group in (self.fit, self.unseen)]
        fit, unseen = (error if np.isfinite(error) else float("inf") for error in errors)
        return replace(self, model=model, rmse_fit_n=fit, rmse_unseen_n=unseen, note=note)

    def delivers(self, promised: float, before: "ModelState") -> bool:
        """Whether the mean squared error (N^2) falls by a good part of what was promised, or by as much as an effect
        must explain to be found."""
        fall = self.fall_from(before)
        return fall > 0.0 and fall >= min(_DELIVERED * promised, limits().gain * before.rmse_unseen_n**2)

    def fall_from(self, before: "ModelState") -> float:
        """By how much the mean squared error on unseen data is lower, N^2."""
        return before.rmse_unseen_n**2 - self.rmse_unseen_n**2

    def fulfils(self, promised: float, before: "ModelState") -> bool:
        """Whether the mean squared error (N^2) falls by nearly all that was promised."""
        return self.fall_from(before) >= _FULFILLED * promised

    def better_than(self, other: "ModelState") -> bool:
        """Whether the unseen error is lower by a share that counts."""
        return self.rmse_unseen_n < (1.0 - limits().least_fall) * other.rmse_unseen_n


def state_of(model: DamperModel, fit: Sequence[Measurement], unseen: Sequence[Measurement]) -> ModelState:
    """The model as given."""
    parts = informative(fit), informative(unseen)
    return ModelState(model, tuple(fit), tuple(unseen), *parts, 0.0, 0.0).with_model(model)


def identified_first(state: ModelState, mode: str) -> ModelState:
    """A model from the library without a record of a fit says nothing of this damper: it is identified before its error
    is read. With mode ``kept``, and where it cannot be identified, it stays as it is.
    """
    if state.model.fit or mode == "kept":
        return state
    try:
        model = identify(state.model, state.fit_part).model
    except InputError:
        return state
    return state.with_model(model, "the model had no record of a fit")


def applied(
    before: ModelState,
    element: Element,
    region: Region,
    mode: str,
    promised: float,
    joint: DamperModel | None = None,
) -> ModelState:
    """With a finding in its place: a fault of the measurement chain in the signal map, an effect in the model.

    All parameters are identified together; if those of added effects alone do better on unseen data (what fits one
    drive may spoil parameters that were right for all), the others are kept. With mode ``kept`` they always are. An
    effect that would not be what it represents any more stays as it was found.

    Args:
        region: of the effect.
        promised: N^2, by how much the search says that the mean squared error on unseen data falls.
        joint: the model with it as the search identified all parameters together. It is where the identification starts
            if that from the present values does not fulfil the promise: an effect may need other values of the rest.
    """
    if element.effect.correct is not None:
        signals = corrected_signals(before.fit[0].signals, element)
        groups = ("fit", "unseen", "fit_part", "unseen_part")
        again = {name: tuple(corrected(m, signals) for m in getattr(before, name)) for name in groups}
        return replace(before, **again).with_model(before.model, "goes to the signal map")
    name = element.effect.name
    after = replace(before, added={**before.added, name: region})
    changed = before.model.with_missing(element)
    found = []
    if mode != "kept":
        found.append(after.with_model(identified(after, changed)))
        if joint is not None and _is_alike(joint, changed) and not found[0].fulfils(promised, before):
            found.append(after.with_model(identified(after, joint)))
    if mode != "refit" and not any(one.fulfils(promised, before) for one in found):
        found.append(after.with_model(identified(after, changed, keep=True), "the other parameters are kept"))
    found = [one for one in found if are_themselves(one.model, one.added)] or [after.with_model(changed)]
    return min(found, key=lambda one: one.rmse_unseen_n)


def _is_alike(one: DamperModel, other: DamperModel) -> bool:
    """Whether two models consist of the same effects in the same places."""
    return [slot.address for slot in one.slots] == [slot.address for slot in other.slots]


def identified(state: ModelState, model: DamperModel, keep: bool = False) -> DamperModel:
    """The model identified from its values; with ``keep`` only the parameters of added effects."""
    if keep and not state.added:
        return model
    choice: dict[str, Sequence[str]] = {"fix": ["*"], "free": list(state.added)} if keep else {}
    try:
        return locally_fitted(model, state.fit_part, **choice, limits=limits_in(model, state.added))
    except InputError:
        return model
