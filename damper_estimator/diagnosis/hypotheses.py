"""What may be missing: every effect that represents a phenomenon, tried as its declaration says.

A `Hypothesis` passes through the stages of the diagnosis: it starts with values and limits from the recordings, gets
a `TrialFit` (`trial_fit`), and then its `Evaluation` on unseen data (`evaluation`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.effects.contract import Effect, number
from damper_estimator.effects.discovery import all_effects
from damper_estimator.effects.trial import Ranges, Trial, Untestable
from damper_estimator.identification import LocalRows, Problem
from damper_estimator.identification.row_sources import RowSource
from damper_estimator.identification.rows import Rows
from damper_estimator.identification.selection import narrowed
from damper_estimator.model import DamperModel, Element, Slot
from damper_estimator.model.element import labels, new_element, walk

if TYPE_CHECKING:  # the later stages import this module
    from damper_estimator.diagnosis.evaluation import Evaluation
    from damper_estimator.diagnosis.trial_fit import TrialFit


@dataclass(frozen=True)
class Region:
    """Where in its parameter space an effect is what it represents.

    Attributes:
        limits: lowest and highest value of parameters by name.
        excludes: says why the effect with some values is not what it represents; None if it always is.
        plausible: by how much values lower its prior, 0 to 1; None if none do.
    """

    limits: Mapping[str, tuple[float, float]]
    excludes: Callable[[Mapping[str, Any]], str] | None = None
    plausible: Callable[[Mapping[str, Any]], float] | None = None

    def exclusion(self, element: Element) -> str:
        """Why an entry of the effect is not what it represents with its values; "" if it is."""
        return self.excludes(_all_values(element)) if self.excludes else ""

    def plausibility(self, element: Element) -> float:
        """By how much an entry's values lower the prior of its effect."""
        return self.plausible(_all_values(element)) if self.plausible else 1.0

    def __getstate__(self) -> dict[str, object]:
        """For another process: results go there, in which nothing is fitted any more, and local functions cannot."""
        return {"limits": dict(self.limits), "excludes": None, "plausible": None}


def _all_values(element: Element) -> dict[str, Any]:
    """Settings and parameters by name."""
    return {**element.settings, **element.parameters}


@dataclass(frozen=True)
class Hypothesis:
    """One effect that may be missing.

    Attributes:
        element: the entry as it would be added, with start values.
        region: where it is what it represents.
        starts: further start values by name.
        imitates: name of the form-free test of what such values imitate; "" if there is none.
        conditions: other settings by name, of which the trial fit takes the best.
        prior: its probability beside others that explain as much, relative to theirs.
        because: a sentence that says what speaks for it beside the recordings; "" for nothing.
        fit: its fitted parameters and what they change; None before the trial fit.
        evaluation: what is left with it on unseen data; None before.
        joint: the model with it, all free parameters fitted together; None where the model's are kept, or refitted to
            first order.
    """

    element: Element
    region: Region
    starts: Sequence[Mapping[str, float]]
    imitates: str = ""
    conditions: Sequence[Mapping[str, float]] = ()
    prior: float = 1.0
    because: str = ""
    fit: TrialFit | None = None
    evaluation: Evaluation | None = None
    joint: DamperModel | None = None

    @property
    def effect(self) -> Effect:
        """Its declaration."""
        return self.element.effect

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.effect.name

    @property
    def phenomenon(self) -> str:
        """Of the effect."""
        return self.effect.phenomenon

    @property
    def tests(self) -> set[str]:
        """Names of the form-free tests that see it. A compliance in front of friction turns it round later, which is a
        memory of the way.
        """
        return {*self.effect.tests, *(("memory",) if self.effect.kind == "series" else ())}

    @property
    def size(self) -> int:
        """Number of its parameters."""
        return sum(1 if p.size is None else len(self.element.parameters[p.name]) for p in self.effect.parameters)

    @property
    def score(self) -> float:
        """Share of the squared error that is left, with penalties for parameters; smaller is better."""
        return self.evaluation.error + limits().penalty * self.size + limits().at_bound * bool(self.fit.at_bound)

    @property
    def fitted_prior(self) -> float:
        """Its prior with its fitted values."""
        return self.prior * self.region.plausibility(self.fitted_element)

    @property
    def exclusion(self) -> str:
        """Why it is not what it represents with its fitted values, or contradicts recordings; "" if neither."""
        if self.evaluation is not None and self.evaluation.remaining.worsened >= limits().contradicted:
            return "raises the error on some of the recordings"
        return self.region.exclusion(self.fitted_element)

    @property
    def exclusion_alone(self) -> str:
        """Why it cannot be the only effect that is missing; "" if it can. It may still be one of a pair: a second
        effect that acts against it hides what only it can change.
        """
        if self.evaluation is not None and self.evaluation.imitates_change:
            return self.exclusion or "explains only what other values of the model's parameters explain as well"
        return self.exclusion

    @property
    def fitted_element(self) -> Element:
        """The entry with the values and settings of the trial fit."""
        return replace(self.element.with_values(self.fit.values), settings=self.fit.settings)

    def under(self, settings: Mapping[str, float]) -> Hypothesis:
        """With other settings, and no further ones to try."""
        return replace(
            self, element=replace(self.element, settings={**self.element.settings, **settings}), conditions=()
        )

    def added_to(self, model: DamperModel) -> tuple[DamperModel, tuple[int, ...]]:
        """The model with the effect, and the positions in its slots of the effect's parameters."""
        changed = model.with_missing(self.element)
        # A compliance gets its path when it is added; the values stay the same object.
        entry = next(i for i, e in enumerate(walk(changed.effects)) if e.parameters is self.element.parameters)
        return changed, tuple(i for i, slot in enumerate(changed.slots) if slot.entry == entry)

    def fitted_into(self, model: DamperModel) -> DamperModel:
        """The model with the effect as its fit left it; ``joint`` where there is one, which is of the same model."""
        return self.joint or replace(self, element=self.fitted_element).added_to(model)[0]

    def continued(self, earlier: Hypothesis | None) -> Hypothesis:
        """To be fitted from where it ended ``earlier`` only, on the same motion with another residual."""
        if earlier is None or not earlier.fit.tried:
            return self
        return replace(self, element=earlier.fitted_element, starts=(), conditions=())

    def resumed(self, earlier: Hypothesis) -> Hypothesis:
        """To be fitted again: where it ended ``earlier``, if it had a part there, is a further start."""
        fit = earlier.fit
        if fit.hidden or not np.any(fit.change_fit):
            return replace(self, fit=None, evaluation=None, joint=None)
        given = {name: value for name, value in self.element.parameters.items() if np.ndim(value) == 0}
        return replace(
            self,
            element=earlier.fitted_element,
            starts=(*self.starts, given),
            conditions=(),
            fit=None,
            evaluation=None,
            joint=None,
        )

    def problem(self, model: DamperModel, rows: Sequence[Rows]) -> Problem:
        """The least-squares problem of the effect's parameters, all others kept."""
        changed, free = self.added_to(model)
        return Problem(changed, LocalRows(rows), free, slots=within(changed, {self.name: self.region}))

    def joint_problem(self, model: DamperModel, source: RowSource) -> Problem:
        """The least-squares problem of the effect's parameters and all free ones of the model."""
        changed, own = self.added_to(model)
        free = [i for i, slot in enumerate(changed.slots) if i in own or not slot.fixed]
        return Problem(changed, source, free, slots=within(changed, {self.name: self.region}))

    def start_points(self, problem: Problem) -> np.ndarray:
        """(s, q) where to begin: the trial's values, then its further starts."""
        points = [problem.start]
        for start in self.starts:
            point = problem.start.copy()
            for k, slot in enumerate(problem.searched):
                point[k] = start.get(problem.slots[slot].parameter.name, point[k])
            points.append(problem.clipped(point))
        return np.array(points)


def entry_of(model: DamperModel, effect: str) -> Element:
    """The entry that was added: an effect's last."""
    return [element for element in walk(model.effects) if element.effect.name == effect][-1]


def without_last(model: DamperModel, effect: str) -> tuple[DamperModel, Element]:
    """The model without the entry of an effect that was added, its last, and the entry."""
    label, element = [(label, one) for label, one in labels(model.effects) if one.effect.name == effect][-1]
    return model.without(label), element


def limits_in(model: DamperModel, added: Mapping[str, Region]) -> dict[str, tuple[float, float]]:
    """Physical limits of the parameters of effects that were added to a model, by address."""
    last = {element.effect.name: label for label, element in labels(model.effects)}
    return {f"{last[effect]}.{name}": ends for effect, one in added.items() for name, ends in one.limits.items()}


def within(model: DamperModel, added: Mapping[str, Region]) -> tuple[Slot, ...]:
    """The model's slots with the physical limits of added effects."""
    return narrowed(model, limits_in(model, added))


def are_themselves(model: DamperModel, added: Mapping[str, Region]) -> bool:
    """Whether all effects that were added to a model are what they represent, with the values that they have there."""
    return not any(region.exclusion(entry_of(model, effect)) for effect, region in added.items())


def hypotheses_for(model: DamperModel, ranges: Ranges) -> tuple[list[Hypothesis], dict[str, str]]:
    """Every effect that can be tried on such recordings, and by name why others cannot."""
    found, untestable = [], {}
    series = [element for element in walk(model.effects) if element.effect.kind == "series"]
    for effect in all_effects().values():
        if not effect.phenomenon or effect.trial is None:
            continue
        try:
            trial = effect.trial(ranges)
            if effect.kind == "series" and series and not _has_place(effect, trial, series, model):
                raise Untestable("there is something in series already; beside it only mount and oil are tried")
            found.append(_hypothesis(effect, model, trial))
        except Untestable as reason:
            untestable[effect.name] = str(reason)
    return found, untestable


def _has_place(effect: Effect, trial: Trial, series: list[Element], model: DamperModel) -> bool:
    """Whether a series effect is tried beside those of a model. Mount and oil stand in front of all else; where a
    spring is in a single path, none is tried. A passage behind them takes long: something must speak for it.
    """
    springs = [element for element in series if element.effect.is_series_spring]
    if effect.is_series_spring:
        return springs == list(model.springs)
    return bool(trial.because) and series == list(model.springs)


def _hypothesis(effect: Effect, model: DamperModel, trial: Trial) -> Hypothesis:
    """The hypothesis with its values and limits between the declared bounds."""
    physical, values = {}, dict(trial.values)
    for parameter in effect.parameters:
        low, high = trial.limits.get(parameter.name, (parameter.lower, parameter.upper))
        low, high = max(low, parameter.lower), min(high, parameter.upper)
        if low >= high:
            raise Untestable(f"no physical {parameter.name.replace('_', ' ')} lies in these ranges")
        if parameter.name in trial.limits:
            physical[parameter.name] = (low, high)
        if parameter.size is None:
            values[parameter.name] = min(max(float(values.get(parameter.name, parameter.default)), low), high)
    present = next((one for one in model.springs if one.effect.of_oil == effect.of_oil), None)
    starts = [*trial.starts, *_as_stiff(effect, present)]
    element = new_element(effect, model.effects, values)
    region = Region(physical, trial.exclusion, trial.plausible)
    return Hypothesis(element, region, starts, trial.imitates, trial.conditions, trial.prior, trial.because)


def _as_stiff(effect: Effect, present: Element | None) -> list[dict[str, float]]:
    """A further start of a series spring: as the one whose place it takes."""
    if not effect.is_series_spring or present is None:
        return []
    if effect is present.effect:
        return [{name: number(present.parameters, name) for name in present.parameters}]
    stiffness = np.mean([number(present.parameters, p.name) for p in present.effect.parameters if p.unit == "N/m"])
    return [{p.name: float(stiffness) for p in effect.parameters if p.unit == "N/m"}]


def settled(added: Collection[str]) -> set[str]:
    """Names of effects that are not tried once some were added: these, and after a series spring all others."""
    effects = all_effects()
    has_spring = any(effects[name].is_series_spring for name in added)
    return {*added, *(name for name, effect in effects.items() if has_spring and effect.is_series_spring)}
