"""Adds what is missing, step by step, until nothing more is justified on unseen data.

Each round diagnoses, puts the findings in one after the other, identifies anew after each, and keeps a step only where
the unseen error falls. At the end effects that later ones made needless are taken out again. Mistakes of the
measurement chain go to the signal map, never into the model.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from damper_estimator.diagnosis.diagnose import diagnose
from damper_estimator.diagnosis.mend import mended, mended_signals
from damper_estimator.diagnosis.result import Diagnosis, Finding, Improvement, Step
from damper_estimator.diagnosis.scene import early, late
from damper_estimator.diagnosis.settle import settled
from damper_estimator.errors import InputError
from damper_estimator.identification import pooled_error, usable
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import labels
from damper_estimator.signals import Measurement

_LEAST_FALL = 0.02  # of the unseen error: a step that brings less is not kept
_NEEDLESS = 0.01  # of the unseen error: an effect without which it grows by less is taken out
_ROUNDS = 3

Progress = Callable[[str, float], None]


@dataclass
class _State:
    """What changes from step to step."""

    model: DamperModel
    fit: list[Measurement]
    unseen: list[Measurement]
    kept: bool
    added: list[str] = field(default_factory=list)  # effects' names, in order
    steps: list[Step] = field(default_factory=list)

    @property
    def error(self) -> float:
        """The unseen error after the last step, N."""
        return self.steps[-1].rmse_unseen_n

    def note(
        self, action: str, finding: Finding | None, model: DamperModel, diagnosis: Diagnosis | None, text: str
    ) -> Step:
        """The step as it would be recorded; it is not, yet."""
        return Step(
            action=action,
            effect=finding.effect if finding else None,
            phenomenon=finding.phenomenon if finding else None,
            model=model,
            rmse_fit_n=pooled_error(model, self.fit)[0],
            rmse_unseen_n=pooled_error(model, self.unseen)[0],
            diagnosis=diagnosis,
            note=text,
        )

    def keep(self, step: Step) -> None:
        """Records a step and goes on from its model."""
        self.model = step.model
        self.steps.append(step)


def improve(
    model: DamperModel,
    fit: Sequence[Measurement],
    unseen: Sequence[Measurement] = (),
    *,
    mode: str = "both",
    workers: int = 1,
    progress: Progress | None = None,
    most: int = 6,
) -> Improvement:
    """The model with everything that is missing and justified.

    Args:
        most: effects that are added at most; the others as in ``diagnose``.

    Raises:
        InputError, ValueError: as ``diagnose``.
    """
    tell = progress or (lambda text, share: None)
    for measurement in (*fit, *unseen):
        usable(model, measurement)  # refuses what cannot be judged, before anything is done
    parts = (list(fit), list(unseen)) if unseen else ([early(m) for m in fit], [late(m) for m in fit])
    state = _State(model, *parts, kept=mode == "kept")
    state.steps.append(state.note("start", None, model, None, "the model as given"))
    first: Diagnosis | None = None
    for number in range(_ROUNDS):
        share = number / _ROUNDS
        own = diagnose(
            state.model, state.fit, state.unseen, mode=mode, workers=workers, skip=state.added,
            progress=lambda text, part, share=share: tell(text, share + 0.6 * part / _ROUNDS),
        )  # fmt: skip
        first = first or own
        before = len(state.steps)
        _follow(state, own, most, lambda text, share=share: tell(text, share + 0.8 / _ROUNDS))
        if len(state.steps) == before:
            break
    _prune(state, tell)
    if len(state.steps) != before:
        own = diagnose(state.model, state.fit, state.unseen, mode=mode, workers=workers, skip=state.added)
    tell("done", 1.0)
    return Improvement(
        steps=tuple(state.steps),
        verdict=own.verdict,
        sentence=_sentence(state, own),
        noise_floor_n=own.noise_floor_n,
        model=state.model,
        signals=state.fit[0].signals,
        rejected=own.ranking,
        fit=tuple(state.fit),
        unseen=tuple(state.unseen),
        first=first,
        final=own,
    )


def _follow(state: _State, own: Diagnosis, most: int, tell: Callable[[str], None]) -> None:
    """Does what a diagnosis says, as far as the unseen error falls."""
    if own.verdict == "parameters_changed":
        tell("identifying what is there")
        step = state.note("refit", None, _identified(state, state.model), own, "parameters changed")
        if step.rmse_unseen_n < (1.0 - _LEAST_FALL) * state.error:
            state.keep(step)
        return
    for finding in sorted(own.findings, key=lambda one: not one.is_channel):  # data before physics
        if len(state.added) >= most:
            return
        tell(f"adding {finding.effect}")
        (_mend if finding.is_channel else _add)(state, finding, own)


def _element(finding: Finding, own: Diagnosis) -> Element:
    return own.elements[own.findings.index(finding)]


def _mend(state: _State, finding: Finding, own: Diagnosis) -> None:
    """Mends the signal map, and the measurements as it would have read them."""
    signals = mended_signals(state.fit[0].signals, _element(finding, own))
    before = state.fit, state.unseen
    state.fit = [mended(m, signals) for m in state.fit]
    state.unseen = [mended(m, signals) for m in state.unseen]
    step = state.note("mend", finding, state.model, own, "goes to the signal map")
    if step.rmse_unseen_n < (1.0 - _LEAST_FALL) * state.error:
        state.keep(step)
    else:
        state.fit, state.unseen = before


def _add(state: _State, finding: Finding, own: Diagnosis) -> None:
    """Adds an effect and identifies all parameters together; where that does not hold on unseen data, those of added
    effects only: what fits one drive may spoil parameters that were right for all.
    """
    changed = state.model.with_effect(_element(finding, own))
    for kept in (False, True)[state.kept :]:
        fitted = _identified(state, changed, finding.effect, kept)
        step = state.note("add", finding, fitted, own, "the other parameters are kept" if kept else "")
        if step.rmse_unseen_n < (1.0 - _LEAST_FALL) * state.error:
            state.keep(step)
            state.added.append(finding.effect)
            return


def _identified(state: _State, model: DamperModel, new: str | None = None, kept: bool | None = None) -> DamperModel:
    """The model with its parameters identified from their values; only those of added effects where the user trusts
    his own, or ``kept`` says so.
    """
    choice: dict[str, Sequence[str]] = {}
    if state.kept if kept is None else kept:
        choice = {"fix": ["*"], "free": [*state.added, *([new] if new else [])]}
        if not choice["free"]:
            return model
    try:
        return settled(model, state.fit, **choice)
    except InputError:
        return model


def _prune(state: _State, tell: Progress) -> None:
    """Takes out effects that later ones made needless."""
    for name in list(state.added[:-1]):
        tell(f"is {name} still needed", 0.95)
        own = [label for label, element in labels(state.model.effects) if element.effect.name == name]
        without = _identified(_less(state, name), state.model.without(own[-1]))
        step = state.note("prune", None, without, None, f"{name} is needless since a later effect was added")
        if step.rmse_unseen_n < (1.0 + _NEEDLESS) * state.error:
            state.added.remove(name)
            state.keep(replace(step, effect=name))


def _less(state: _State, name: str) -> _State:
    """The state as if one effect had not been added."""
    return replace(state, added=[other for other in state.added if other != name])


def _sentence(state: _State, own: Diagnosis) -> str:
    first, last = state.steps[0].rmse_unseen_n, state.error
    done = [step for step in state.steps[1:] if step.effect or step.action == "refit"]
    if not done:
        return f"Nothing was added: {own.sentence}"
    words = {"add": "added {}", "mend": "{} mended in the signal map", "prune": "{} taken out again"}
    said = [words.get(s.action, "parameters identified anew").format(s.effect) for s in done]
    floor = own.noise_floor_n
    above = f", {last / floor:.1f} times the noise floor" if np.isfinite(floor) and floor > 0.0 else ""
    return f"{', '.join(said)}: the unseen error falls from {first:.3g} to {last:.3g} N{above}."
