"""The long works of a page: functions that run in a process of their own, on what the page has opened."""

from collections.abc import Sequence
from dataclasses import dataclass

from damper_estimator.diagnosis import Diagnosis, Improvement, Step, diagnose, improve
from damper_estimator.diagnosis.settle import settled
from damper_estimator.identification import pooled_error
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import labels
from damper_estimator.signals import Measurement
from damper_estimator.studio.apart import Tell


@dataclass(frozen=True)
class Case:
    """A model, the measurements that parameters are found on, and those that are judged on."""

    model: DamperModel
    fit: Sequence[Measurement]
    unseen: Sequence[Measurement]


@dataclass(frozen=True)
class Deed:
    """What a step does, for the record: action, effect and phenomenon as in ``diagnosis.Step``."""

    action: str
    effect: str | None = None
    phenomenon: str | None = None


def diagnosed(case: Case, mode: str, workers: int, tell: Tell) -> Diagnosis:
    """What the model lacks."""
    return diagnose(case.model, case.fit, case.unseen, mode=mode, workers=workers, progress=tell)


def improved(case: Case, mode: str, workers: int, tell: Tell) -> Improvement:
    """The model with all that is justified."""
    return improve(case.model, case.fit, case.unseen, mode=mode, workers=workers, progress=tell)


def refitted(case: Case, deed: Deed, tell: Tell) -> Step:
    """The model with its free parameters identified from their values."""
    tell(f"identifying {case.model.name}", 0.1)
    found = settled(case.model, case.fit)
    tell("judging", 0.9)
    return judged(Case(found, case.fit, case.unseen), deed)


def identified_alone(case: Case, element: Element, tell: Tell) -> Element:
    """An entry with its parameters identified beside a model that keeps its own."""
    tell(f"identifying {element.effect.name}", 0.1)
    model = case.model.with_effect(element)
    label = [own for own, entry in labels(model.effects) if entry.effect is element.effect][-1]
    found = settled(model, case.fit, free=[label], fix=["*"])
    return dict(labels(found.effects))[label]


def judged(case: Case, deed: Deed) -> Step:
    """A step with the errors of its model."""
    errors = [pooled_error(case.model, own)[0] for own in (case.fit, case.unseen)]
    return Step(deed.action, deed.effect, deed.phenomenon, case.model, *errors, None, "")
