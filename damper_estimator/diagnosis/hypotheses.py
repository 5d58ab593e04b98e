"""Explanations of the same error, each as the model with its effect in it: what a test has to tell apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.adopt import identified_first, standpoint
from damper_estimator.diagnosis.attempt import attempt
from damper_estimator.diagnosis.candidates import candidates
from damper_estimator.diagnosis.misfit import without_misfit
from damper_estimator.diagnosis.null import near_derivatives, null, slot_size
from damper_estimator.diagnosis.scene import force_rows, scene, targets
from damper_estimator.effects.discovery import all_effects
from damper_estimator.effects.trial import Ranges
from damper_estimator.errors import InputError
from damper_estimator.identification import usable
from damper_estimator.identification.rows import Rows
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement

_FORMS = 2  # effects of a phenomenon, at most
_NEAR = 1.3  # times the squared error of the best


@dataclass(frozen=True)
class Hypothesis:
    """One explanation, fitted.

    Attributes:
        phenomenon, effect: what is missing, "" where the model is taken as it is.
        model: with the effect.
        residual: (r,) N, modelled less measured in the rows of the recordings.
        free: positions in ``model.slots`` of the parameters that a refit moves.
        sensitivity: (r, k) derivatives of the rows by these, each times the parameter's size.
        sizes: (k,) of these parameters.
    """

    phenomenon: str
    effect: str
    model: DamperModel
    residual: np.ndarray
    free: tuple[int, ...]
    sensitivity: np.ndarray
    sizes: np.ndarray


@dataclass(frozen=True)
class Explanations:
    """Hypotheses on the same rows.

    Attributes:
        model: without any of them, identified where it had no record of a fit.
        rows: of the recordings, the gauge's zero and drift left out.
        ranges: what the recordings drive.
        untestable: by effect, why these recordings cannot show it.
    """

    model: DamperModel
    hypotheses: tuple[Hypothesis, ...]
    rows: tuple[Rows, ...]
    ranges: Ranges
    untestable: Mapping[str, str]


def explanations(model: DamperModel, measurements: Sequence[Measurement], phenomena: Sequence[str]) -> Explanations:
    """The model with each phenomenon's effects, fitted to all recordings with the model's parameters kept.

    A phenomenon is there as its best effect and as others that leave about as little: the rival may take any form.
    Without phenomena the model as it is, alone.

    Raises:
        InputError: where a recording cannot be used, or cannot show a phenomenon.
    """
    whole = [m.part(p.start, p.stop) for m in measurements for p in usable(model, m)]
    model = identified_first(standpoint(model, whole, whole[:1]), "both").model
    news = [without_misfit(model, m) for m in whole] if phenomena else whole
    stage = scene(model, news, news)
    stage = replace(stage, unseen=stage.unseen[:1])
    tried, untestable = candidates(model, stage.ranges)
    if not phenomena:
        hypotheses = (_hypothesis("", "", model, stage.fit),)
        return Explanations(model, hypotheses, stage.fit, stage.ranges, untestable)
    bare = null(model, stage, base=())
    found = []
    for phenomenon in phenomena:
        hypotheses = [candidate for candidate in tried if candidate.effect.phenomenon == phenomenon]
        if not hypotheses:
            effects = (name for name, effect in all_effects().items() if effect.phenomenon == phenomenon)
            why = next((untestable[name] for name in effects if name in untestable), "no effect stands for it")
            raise InputError(f"{measurements[0].recording}: cannot show {phenomenon} ({why}); plan without it")
        ends = [(attempt(bare, candidate), candidate) for candidate in hypotheses]
        left = np.array([float(np.sum((bare.residual_fit + one.change_fit) ** 2)) for one, _ in ends])
        for i in np.argsort(left, kind="stable")[:_FORMS]:
            one, candidate = ends[i]
            if left[i] <= _NEAR * left.min():
                with_it = replace(candidate, element=one.element(candidate)).added_to(model)[0]
                found.append(_hypothesis(phenomenon, one.effect, with_it, stage.fit))
    return Explanations(model, tuple(found), stage.fit, stage.ranges, untestable)


def sensitivities(hypothesis: Hypothesis, rows: Sequence[Rows]) -> tuple[np.ndarray, np.ndarray]:
    """Force rows (r,) in N and their derivatives (r, k) by the free parameters times their sizes, on other motions."""
    force = force_rows(hypothesis.model, rows)
    return force, near_derivatives(hypothesis.model, rows, hypothesis.free, force)


def _hypothesis(phenomenon: str, effect: str, model: DamperModel, rows: Sequence[Rows]) -> Hypothesis:
    free = tuple(i for i, slot in enumerate(model.slots) if not slot.fixed)
    force = force_rows(model, rows)
    sizes = np.array([slot_size(model.slots[i]) for i in free])
    return Hypothesis(
        phenomenon, effect, model, force - targets(rows), free, near_derivatives(model, rows, free, force), sizes
    )
