"""Adds what is missing, step by step, until nothing more is justified on unseen data.

Each round diagnoses, adds the findings one after the other, identifies again after each, and keeps a step only if the
unseen error falls. At the end effects that later ones made redundant are removed. Faults of the measurement chain are
corrected in the signal map, never in the model.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from damper_estimator.diagnosis.apply_finding import ModelState, identified, identified_first
from damper_estimator.diagnosis.diagnose import begun, diagnose
from damper_estimator.diagnosis.free_curve import in_place_of
from damper_estimator.diagnosis.hypotheses import settled, without_last
from damper_estimator.diagnosis.improvement import Improvement, Step
from damper_estimator.diagnosis.misfit import IMPROVED, with_misfit
from damper_estimator.diagnosis.other_form import in_another_form
from damper_estimator.diagnosis.result import Diagnosis, Finding
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.identification.error_bound import force_stddev, worst_errors
from damper_estimator.identification.fit_record import error_record
from damper_estimator.identification.rows import force_rms
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement

_ROUNDS = 4

Progress = Callable[[str, float], None]


@dataclass
class _Improving:
    """What changes from step to step."""

    current: ModelState
    mode: str
    steps: list[Step] = field(default_factory=list)

    def keep(
        self,
        action: str,
        current: ModelState,
        finding: Finding | None,
        diagnosis: Diagnosis | None,
        note: str = "",
        **more: Any,
    ) -> None:
        """Records a step and continues from it; ``more`` are its attributes where no finding states them."""
        self.current = current
        step = Step(
            action=action,
            effect=finding.effect if finding else None,
            phenomenon=finding.phenomenon if finding else None,
            model=current.model,
            rmse_fit_n=current.rmse_fit_n,
            rmse_unseen_n=current.rmse_unseen_n,
            diagnosis=diagnosis,
            note=note or current.note,
        )
        self.steps.append(replace(step, **more))


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
    report = progress or (lambda text, share: None)
    improving = _Improving(begun(model, fit, unseen), mode)
    improving.keep("start", improving.current, None, None, "the model as given")
    current = identified_first(improving.current, mode)
    if current is not improving.current:
        improving.keep("refit", current, None, None)
    first: Diagnosis | None = None
    for number in range(_ROUNDS):
        found = _diagnosed(
            improving, workers, lambda text, part, done=number / _ROUNDS: report(text, done + part / _ROUNDS)
        )
        first = first or found
        before = len(improving.steps)
        _follow(improving, found, most)
        if len(improving.steps) == before and not _change_form(improving, found):
            break
    _prune(improving, report)
    if len(improving.steps) != before:
        found = _diagnosed(improving, workers, lambda text, part: report(text, 1.0))
    report("done", 1.0)
    return Improvement(
        steps=tuple(improving.steps),
        verdict=found.verdict,
        sentence=_sentence(improving, found),
        noise_floor_n=found.noise_floor_n,
        model=_with_record(improving, found),
        signals=improving.current.fit[0].signals,
        rejected=found.ranking,
        fit=improving.current.fit,
        unseen=improving.current.unseen,
        first=first,
        final=found,
    )


def _with_record(improving: _Improving, last: Diagnosis) -> DamperModel:
    """The model as improved, with what it gets wrong on all of the recordings; as given where nothing was improved.

    Where it was identified here, its record states its error on unseen data, or that of the identification where that
    is the larger share of the force, bounds the force over all of the recordings, and says whether nothing that the
    last diagnosis could name is left.
    """
    current, model = improving.current, improving.current.model
    if len(improving.steps) == 1:
        return model
    everything = [*current.fit, *current.unseen]
    if current.is_identified_here:
        parts = (current.rmse_fit_n, force_rms(current.fit)), (current.rmse_unseen_n, force_rms(current.unseen))
        error, force = max(parts, key=lambda part: part[0] / max(part[1], 1e-300))
        bound = force_stddev(worst_errors(model, everything))
        is_improved = last.verdict in ("nothing_missing", "unexplained")
        model = replace(model, fit={**model.fit, **error_record((error, bound), force), IMPROVED: is_improved})
    return with_misfit(model, everything)


def _diagnosed(improving: _Improving, workers: int, progress: Progress) -> Diagnosis:
    current = improving.current
    return diagnose(
        current.model,
        current.fit,
        current.unseen,
        mode=improving.mode,
        workers=workers,
        skip=settled(current.added),
        progress=progress,
    )


def _follow(improving: _Improving, found: Diagnosis, most: int) -> None:
    """Takes the steps that a diagnosis proposes; a freer curve alone, because effects are judged beside the curve."""
    if found.verdict == "parameters_changed":
        current = improving.current
        step = current.with_model(identified(current, current.model), "parameters changed")
        if step.better_than(current):
            improving.keep("refit", step, None, found)
        return
    added, curve = improving.current.added, found.free_curve
    if curve is not None:
        kept = {name: region for name, region in added.items() if name in curve.state.model.uses()}
        state, why = replace(curve.state, added=kept), "it leaves less than what was found"
        improving.keep("add", state, None, found, why, effect=curve.effect, replaced=curve.replaced)
        return
    for finding, step in found.steps:
        current = replace(step, added={**added, **step.added})
        if len(current.added) <= most:
            improving.keep("correct" if finding.is_channel else "add", current, finding, found)


def _change_form(improving: _Improving, found: Diagnosis) -> bool:
    """Puts a better form in place of what the model has of a phenomenon, where much is unexplained."""
    if found.verdict != "unexplained" or improving.mode == "kept":
        return False
    better = in_another_form(improving.current)
    if better is None:
        return False
    state, label, form = better
    improving.keep("add", state, None, found, effect=form.name, phenomenon=form.phenomenon, replaced=(label,))
    return True


def _prune(improving: _Improving, report: Progress) -> None:
    """Removes effects that later ones made redundant."""
    for name in list(improving.current.added)[:-1]:
        report(f"is {name} still needed", 0.95)
        current = improving.current
        less = replace(current, added={other: at for other, at in current.added.items() if other != name})
        without = less.with_model(identified(less, without_last(current.model, name)[0], improving.mode == "kept"))
        if without.rmse_unseen_n < (1.0 + limits().needless) * current.rmse_unseen_n:
            why = f"{name} is needless since a later effect was added"
            improving.keep("prune", without, None, None, why, effect=name)


def _sentence(improving: _Improving, found: Diagnosis) -> str:
    first, last = improving.steps[0].rmse_unseen_n, improving.current.rmse_unseen_n
    done = [step for step in improving.steps[1:] if step.effect or step.action == "refit"]
    if not done:
        return f"Nothing was added: {found.sentence}"
    words = {"add": "added {}", "correct": "{} corrected in the signal map", "prune": "{} removed again"}
    said = [words.get(s.action, "parameters identified again").format(s.effect) + in_place_of(s.replaced) for s in done]
    floor = found.noise_floor_n
    above = f", {last / floor:.1f} times the noise floor" if np.isfinite(floor) and floor > 0.0 else ""
    more = found.verdict != "unexplained" and found.reference_n < (1.0 - limits().least_fall) * last
    least = f", and a regression without any form reaches {found.reference_n:.3g} N" if more else ""
    fall = f"the unseen error falls from {first:.3g} to {last:.3g} N"
    return f"{', '.join(said)}: {fall}{above}{least}. {_why_it_ends(found)}"


def _why_it_ends(found: Diagnosis) -> str:
    """Why nothing more was added after the last diagnosis."""
    if found.verdict == "unexplained" or (found.verdict == "missing" and not found.steps):
        return found.sentence
    if found.verdict == "missing":
        return f"It ends although {found.findings[0].effect} may be missing: no more effects are added at a time."
    best = found.ranking[0] if found.ranking else None
    return (
        f"Nothing more is justified: {best.effect}, the best candidate: {best.reason}."
        if best and best.reason
        else ("Nothing more is justified.")
    )
