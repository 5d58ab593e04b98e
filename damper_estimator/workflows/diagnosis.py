"""Which physical effects a model lacks, how sure that is, and what else it could be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from damper_estimator.diagnosis import Diagnosis, Finding
from damper_estimator.diagnosis import diagnose as diagnosed
from damper_estimator.model import DamperModel
from damper_estimator.workflows.judging import Case, Tell, check_mode, judging_of, silent
from damper_estimator.workflows.models import ModelLike
from damper_estimator.workflows.recording import Recording, in_words
from damper_estimator.workflows.results import Results


@dataclass(frozen=True, repr=False, eq=False)
class DiagnosisResults(Results[Diagnosis]):
    """What models lack, by damper.

    For one damper (``result["front_left"]`` where there are several) the verdict and the findings are at hand.
    """

    @property
    def diagnosis(self) -> Diagnosis:
        """All that was found about one damper."""
        return self.only

    @property
    def verdict(self) -> str:
        """``missing``, ``nothing_missing``, ``parameters_changed`` or ``unexplained``."""
        return self.only.verdict

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        return self.only.sentence

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Effects that are missing, best first."""
        return self.only.findings

    @property
    def improved(self) -> DamperModel:
        """The model with the findings put in, refitted to first order; ``improve`` does it thoroughly."""
        return self.only.improved

    def page(self) -> str:
        """One self-contained HTML page: the verdict, what could explain the error, forces before and after."""
        from damper_estimator.report import diagnosis_page, diagnosis_section

        sections = [diagnosis_section(damper, own) for damper, own in self.by_damper.items()]
        return diagnosis_page(sections, f"what {self.asked['model']} lacks on {in_words(self.asked['bags'])}")

    def _record(self, own: Diagnosis) -> dict[str, object]:
        return {"model": own.model.name, **own.record()}

    def _title(self) -> str:
        return "; ".join(f"{damper}: {own.sentence}" for damper, own in self.by_damper.items())

    def _line(self, own: Diagnosis) -> str:
        named = ", ".join(f"{finding.phenomenon} ({100 * finding.confidence:.0f} %)" for finding in own.findings)
        return f"{own.verdict}{': ' if named else ''}{named}, {own.rmse_n:.4g} N rms unseen"

    def _rows(self, own: Diagnosis) -> list[dict[str, object]]:
        return [
            {
                "phenomenon": finding.phenomenon,
                "effect": finding.effect,
                "tied_with": ", ".join(finding.tied_with),
                "rmse_before_n": finding.rmse_before_n,
                "rmse_after_n": finding.rmse_after_n,
                "share_of_explainable_error": finding.share_of_explainable_error,
                "confidence": finding.confidence,
            }
            for finding in own.findings
        ]

    def _figure(self, own: Diagnosis) -> Mapping[str, object]:
        from damper_estimator.report import ranking_figure

        return ranking_figure(own.ranking, own.findings, {})


def diagnose(
    recording: Recording,
    model: ModelLike,
    *,
    validate: Recording | None = None,
    mode: str = "both",
    workers: int = 1,
    progress: Tell | None = None,
) -> DiagnosisResults:
    """Tries every effect that stands for a phenomenon on the model, and judges it on recordings it was not fitted to.

    Args:
        recording: what was measured; dampers without a force are left out.
        model: the one to improve on: a name of the library, a model file, a folder with one ``DAMPER.yaml`` each, a
            model, or a mapping of these by damper.
        validate: recordings to judge on; None keeps the last 40 % of each recording back.
        mode: ``kept`` judges each effect with the model's parameters as they are (the damper was right yesterday: what
            is new?), ``refit`` refitted together with them, ``both`` does both and says where they disagree.
        workers: processes that work.
        progress: receives what goes on and its share of the work, 0 to 1.

    Raises:
        InputError: one line; without a measured force, for a model that cannot be used, and for too few samples.
    """
    check_mode(mode)
    given = judging_of(recording, model, validate, "diagnose")
    return DiagnosisResults(
        given.asked, {case.damper: diagnose_case(case, mode, workers, progress or silent) for case in given.cases}
    )


def diagnose_case(case: Case, mode: str, workers: int, tell: Tell) -> Diagnosis:
    """The diagnosis of one damper."""
    return diagnosed(case.model, case.fit, case.unseen, mode=mode, workers=workers, progress=tell)
