"""The long works of a page: functions that run in a process of their own, on what the page has opened."""

from dataclasses import dataclass, replace

from damper_estimator.diagnosis import Step, locally_fitted
from damper_estimator.identification import pooled_error
from damper_estimator.model import Element
from damper_estimator.model.element import labels
from damper_estimator.studio.worker_process import Progress
from damper_estimator.workflows import Case, diagnose_case, improve_case

__all__ = ["Case", "Change", "diagnose_case", "identified_alone", "improve_case", "judged", "refitted"]


@dataclass(frozen=True)
class Change:
    """What a step does, for the record: action, effect and phenomenon as in ``diagnosis.Step``."""

    action: str
    effect: str | None = None
    phenomenon: str | None = None


def refitted(case: Case, change: Change, progress: Progress) -> Step:
    """The model with its free parameters identified from their values."""
    progress(f"identifying {case.model.name}", 0.1)
    found = locally_fitted(case.model, case.fit)
    progress("judging", 0.9)
    return judged(replace(case, model=found), change)


def identified_alone(case: Case, element: Element, progress: Progress) -> Element:
    """An entry with its parameters identified while the model's are kept."""
    progress(f"identifying {element.effect.name}", 0.1)
    model = case.model.with_missing(element)
    label = [name for name, entry in labels(model.effects) if entry.effect is element.effect][-1]
    found = locally_fitted(model, case.fit, free=[label], fix=["*"])
    return dict(labels(found.effects))[label]


def judged(case: Case, change: Change) -> Step:
    """A step with the errors of its model."""
    errors = [pooled_error(case.model, group)[0] for group in (case.fit, case.unseen)]
    return Step(change.action, change.effect, change.phenomenon, case.model, *errors, None, "")
