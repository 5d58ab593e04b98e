"""Engines with fixed results in place of the search, to test what the verbs do with a diagnosis."""

from dataclasses import replace

from damper_estimator.diagnosis import Diagnosis, EvaluationSummary, Finding, Improvement, RankedEffect, Step
from damper_estimator.effects.discovery import find_effect
from damper_estimator.identification import FittedParameter
from damper_estimator.model import make_element
from damper_estimator.validation import DataFinding

FRICTION = Finding(
    effect="coulomb",
    phenomenon="friction",
    tied_with=("hysteresis",),
    rmse_before_n=100.0,
    rmse_after_n=20.0,
    share_of_explainable_error=0.97,
    confidence=0.93,
    gain=0.96,
    low=0.9,
    high=0.98,
    evidence="A step at every reversal.",
    test_to_separate="Move it slowly.",
    remark="",
    parameters=(FittedParameter("coulomb.force", 61234.0, 120.0, "N", False),),
    is_channel=False,
)
OFFSET = replace(
    FRICTION,
    effect="force_offset",
    phenomenon="force_offset",
    tied_with=(),
    is_channel=True,
    evidence="It is never zero.",
)
GAPS = DataFinding("gaps", "12 gaps of more than 0.1 s.", "Record to a faster disk.", "/data/a.mcap", 0.1)


class Engine:
    """Replaces ``diagnose`` or ``improve``: records its calls, and reports friction or an offset of the gauge."""

    def __init__(self, finding=FRICTION):
        self.finding, self.calls = finding, []

    def diagnose(self, model, fit, unseen=(), *, mode="both", workers=1, progress=None):
        self.calls.append({"model": model, "fit": fit, "unseen": unseen, "mode": mode, "workers": workers})
        progress("trying effects", 0.5)
        finding, signals, improved = self.finding, fit[0].signals, model
        element = make_element(find_effect(finding.effect))
        if finding.is_channel:
            signals = replace(signals, force=replace(signals.force, offset=-35.0))
        else:
            improved = model.with_effect(element)
        judgement = EvaluationSummary(20.0, 0.96, 0.9, 0.98)
        other = RankedEffect("gas_spring", "gas_spring", judgement, None, (), "explains nothing on unseen data")
        return Diagnosis(
            model=model,
            verdict="missing",
            sentence=f"Missing: {finding.phenomenon}.",
            mode=mode,
            rmse_n=100.0,
            force_rms_n=500.0,
            noise_floor_n=5.0,
            findings=(finding,),
            elements=(element,),
            ranking=(
                RankedEffect(finding.effect, finding.phenomenon, judgement, judgement, finding.parameters, ""),
                other,
            ),
            untestable={"temperature_gain": "no temperature was recorded"},
            moved=(),
            rmse_refit_alone_n=90.0,
            structure=None,
            improved=improved,
            signals=signals,
            data=(GAPS,),
            fit=tuple(fit),
            unseen=tuple(unseen or fit),
        )

    def improve(self, model, fit, unseen=(), *, mode="both", workers=1, progress=None, most=6):
        first = self.diagnose(model, fit, unseen, mode=mode, workers=workers, progress=progress)
        finding = self.finding
        action = "correct" if finding.is_channel else "add"
        start = Step("start", None, None, model, 101.0, 100.0, None, "the model as given")
        step = Step(action, finding.effect, finding.phenomenon, first.improved, 19.0, 20.0, first, "")
        last = replace(first, model=first.improved, verdict="nothing_missing", findings=(), elements=())
        return Improvement(
            steps=(start, step),
            verdict=last.verdict,
            sentence="The unseen error falls.",
            noise_floor_n=5.0,
            model=first.improved,
            signals=first.signals,
            rejected=last.ranking,
            fit=first.fit,
            unseen=first.unseen,
            final=last,
            first=first,
        )
