"""Names the physical effects that a model lacks, as far as recordings tell.

The order: candidates are fitted with the model's parameters kept, judged on unseen data, the best is put in, and the
next round looks for what is left. Beside that the model is re-identified as it is, to tell a change of what is there
from something new.
"""

from collections.abc import Callable, Collection, Sequence

from damper_estimator.diagnosis.mend import mended_signals
from damper_estimator.diagnosis.reidentify import Reidentified, reidentified
from damper_estimator.diagnosis.report import finding_of, judged_of, sentence_of
from damper_estimator.diagnosis.result import Diagnosis
from damper_estimator.diagnosis.scene import Scene, scene
from damper_estimator.diagnosis.search import Search, search
from damper_estimator.diagnosis.verdict import verdict_on
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.validation import Comparison, compare, data_findings

MODES = ("both", "kept", "refit")


def diagnose(
    model: DamperModel,
    fit: Sequence[Measurement],
    unseen: Sequence[Measurement] = (),
    *,
    mode: str = "both",
    workers: int = 1,
    progress: Callable[[str, float], None] | None = None,
    skip: Collection[str] = (),
) -> Diagnosis:
    """Which effects are missing.

    Args:
        model: the user's, with parameters that were identified before.
        fit: recordings that parameters are found on.
        unseen: recordings that explanations are judged on; without, the last 40 % of each of ``fit``.
        mode: ``both``; ``kept``: the model's parameters are trusted; ``refit``: they are not.
        workers: processes.
        progress: is told what goes on and its share; what it raises ends the work.
        skip: effects that are not tried.

    Raises:
        InputError: where a recording has no force, or lacks a channel that the model needs.
        ValueError: unknown mode.
    """
    if mode not in MODES:
        raise ValueError(f"mode {mode!r} is none of {', '.join(MODES)}")
    tell = progress or (lambda text, share: None)
    tell("reading the model's error", 0.0)
    stage = scene(model, fit, unseen)
    found = search(model, stage, mode, skip, workers, lambda text, share: tell(text, 0.05 + 0.8 * share))
    tell("identifying what is there", 0.9)
    again = reidentified(found.rounds[0], stage) if mode != "kept" else None
    before = compare(model, *(own.measurement for own in stage.unseen))
    tell("done", 1.0)
    return _told(found, again, stage, before)


def _told(found: Search, again: Reidentified | None, stage: Scene, before: Comparison) -> Diagnosis:
    force, floor = before.measures.force_rms_n, before.noise_floor_n
    verdict, picture = verdict_on(found, again, force, floor)
    findings = tuple(finding_of(one, floor, again) for one in found.accepted)
    elements = tuple(one.element for one in found.accepted)
    signals = stage.fit[0].measurement.signals
    for element in elements:
        if element.effect.mend is not None:
            signals = mended_signals(signals, element)
    fit, unseen = (tuple(own.measurement for own in rows) for rows in (stage.fit, stage.unseen))
    return Diagnosis(
        model=before.model,
        verdict=verdict,
        sentence=sentence_of(verdict, findings, again, picture, before.measures.rmse_n, found.left_n, floor),
        mode=found.mode,
        rmse_n=before.measures.rmse_n,
        force_rms_n=force,
        noise_floor_n=floor,
        findings=findings,
        elements=elements,
        ranking=judged_of(found, force),
        untestable=found.untestable,
        moved=again.moved if again is not None and verdict == "parameters_changed" else (),
        rmse_refit_alone_n=again.rmse_n if again is not None else float("nan"),
        structure=picture,
        improved=_improved(found),
        signals=signals,
        data=tuple(data_findings(before.model, [*fit, *unseen])),
        fit=fit,
        unseen=unseen,
    )


def _improved(found: Search) -> DamperModel:
    """The model with the damper's findings; what belongs to the measurement chain is taken out again."""
    model = found.model
    for label in reversed(model.channel_effects):
        if label not in found.rounds[0].null.model.channel_effects:
            model = model.without(label)
    return model
