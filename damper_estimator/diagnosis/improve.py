"""Adds what is missing, step by step, until nothing more is justified on unseen data.

Each round diagnoses, puts the findings in one after the other, identifies anew after each, and keeps a step only where
the unseen error falls. At the end effects that later ones made needless are taken out again. Mistakes of the
measurement chain go to the signal map, never into the model.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from damper_estimator.diagnosis.adopt import Standpoint, identified, identified_first
from damper_estimator.diagnosis.diagnose import begun, diagnose
from damper_estimator.diagnosis.misfit import with_misfit
from damper_estimator.diagnosis.result import Diagnosis, Finding, Improvement, Step
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.model import DamperModel
from damper_estimator.model.element import labels
from damper_estimator.signals import Measurement

_ROUNDS = 4

Progress = Callable[[str, float], None]


@dataclass
class _State:
    """What changes from step to step."""

    place: Standpoint
    mode: str
    steps: list[Step] = field(default_factory=list)

    def keep(
        self, action: str, place: Standpoint, finding: Finding | None, diagnosis: Diagnosis | None, note: str = ""
    ) -> None:
        """Records a step and goes on from there."""
        self.place = place
        self.steps.append(
            Step(
                action=action,
                effect=finding.effect if finding else None,
                phenomenon=finding.phenomenon if finding else None,
                model=place.model,
                rmse_fit_n=place.rmse_fit_n,
                rmse_unseen_n=place.rmse_unseen_n,
                diagnosis=diagnosis,
                note=note or place.note,
            )
        )


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
    state = _State(begun(model, fit, unseen), mode)
    state.keep("start", state.place, None, None, "the model as given")
    place = identified_first(state.place, mode)
    if place is not state.place:
        state.keep("refit", place, None, None)
    first: Diagnosis | None = None
    for number in range(_ROUNDS):
        found = _diagnosed(state, workers, lambda text, part, done=number / _ROUNDS: tell(text, done + part / _ROUNDS))
        first = first or found
        before = len(state.steps)
        _follow(state, found, most)
        if len(state.steps) == before:
            break
    _prune(state, tell)
    if len(state.steps) != before:
        found = _diagnosed(state, workers, lambda text, part: tell(text, 1.0))
    tell("done", 1.0)
    return Improvement(
        steps=tuple(state.steps),
        verdict=found.verdict,
        sentence=_sentence(state, found),
        noise_floor_n=found.noise_floor_n,
        model=with_misfit(state.place.model, state.place.fit) if len(state.steps) > 1 else state.place.model,
        signals=state.place.fit[0].signals,
        rejected=found.ranking,
        fit=state.place.fit,
        unseen=state.place.unseen,
        first=first,
        final=found,
    )


def _diagnosed(state: _State, workers: int, progress: Progress) -> Diagnosis:
    place = state.place
    return diagnose(
        place.model, place.fit, place.unseen, mode=state.mode, workers=workers, skip=place.added, progress=progress
    )


def _follow(state: _State, found: Diagnosis, most: int) -> None:
    """Takes the steps that a diagnosis proposes."""
    if found.verdict == "parameters_changed":
        place = state.place
        step = place.with_model(identified(place, place.model), "parameters changed")
        if step.better_than(place):
            state.keep("refit", step, None, found)
        return
    added = state.place.added
    for finding, step in found.steps:
        place = replace(step, added=(*added, *step.added))
        if len(place.added) <= most:
            state.keep("correct" if finding.is_channel else "add", place, finding, found)


def _prune(state: _State, tell: Progress) -> None:
    """Takes out effects that later ones made needless."""
    for name in list(state.place.added[:-1]):
        tell(f"is {name} still needed", 0.95)
        place = state.place
        present = [label for label, element in labels(place.model.effects) if element.effect.name == name]
        less = replace(place, added=tuple(other for other in place.added if other != name))
        without = less.with_model(identified(less, place.model.without(present[-1]), state.mode == "kept"))
        if without.rmse_unseen_n < (1.0 + limits().needless) * place.rmse_unseen_n:
            state.keep("prune", without, None, None, f"{name} is needless since a later effect was added")
            state.steps[-1] = replace(state.steps[-1], effect=name)


def _sentence(state: _State, found: Diagnosis) -> str:
    first, last = state.steps[0].rmse_unseen_n, state.place.rmse_unseen_n
    done = [step for step in state.steps[1:] if step.effect or step.action == "refit"]
    if not done:
        return f"Nothing was added: {found.sentence}"
    words = {"add": "added {}", "correct": "{} corrected in the signal map", "prune": "{} removed again"}
    said = [words.get(s.action, "parameters identified again").format(s.effect) for s in done]
    floor = found.noise_floor_n
    above = f", {last / floor:.1f} times the noise floor" if np.isfinite(floor) and floor > 0.0 else ""
    return f"{', '.join(said)}: the unseen error falls from {first:.3g} to {last:.3g} N{above}."
