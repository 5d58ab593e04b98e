"""Finds the physical effects that a model lacks, with confidence and alternatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from damper_estimator.diagnosis import Diagnosis, Finding
from damper_estimator.diagnosis import diagnose as diagnosed
from damper_estimator.model import DamperModel
from damper_estimator.workflows.cases import Case, Progress, check_mode, diagnosis_cases, no_progress
from damper_estimator.workflows.model_arguments import ModelLike
from damper_estimator.workflows.recording import Recording, in_words
from damper_estimator.workflows.results import Results

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


@dataclass(frozen=True, repr=False, eq=False)
class DiagnosisResults(Results[Diagnosis]):
    """The effects that models lack, by damper.

    The properties are those of one damper (``result["front_left"]`` selects one of several).
    """

    @property
    def diagnosis(self) -> Diagnosis:
        """The complete diagnosis of one damper."""
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
        """The model with the findings added and identified; ``improve`` goes on until nothing more is found."""
        return self.only.improved

    def curves_figure(self, damper: str | None = None) -> Figure:
        """A Plotly figure of what the model lacks over each variable, given the others; empty if no curve says
        anything. ``damper`` is required if there are several.

        Raises:
            InputError: if there are several and none is named, or the name is unknown.
        """
        from damper_estimator.report import command_unit, curves_figure, plotly_figure

        result = self._of(damper)
        return plotly_figure(curves_figure(result.curves, command_unit(result)))

    def page(self) -> str:
        """One self-contained HTML page: verdict, possible explanations, forces before and after."""
        from damper_estimator.report import diagnosis_page, diagnosis_section

        sections = [diagnosis_section(damper, result) for damper, result in self.by_damper.items()]
        return diagnosis_page(sections, f"what {self.request['model']} lacks on {in_words(self.request['bags'])}")

    def _record(self, result: Diagnosis) -> dict[str, object]:
        return {"model": result.model.name, **result.record()}

    def _title(self) -> str:
        return "; ".join(f"{damper}: {result.sentence}" for damper, result in self.by_damper.items())

    def _line(self, result: Diagnosis) -> str:
        named = ", ".join(f"{finding.phenomenon} ({100 * finding.confidence:.0f} %)" for finding in result.findings)
        return f"{result.verdict}{': ' if named else ''}{named}, {result.rmse_n:.4g} N rms unseen"

    def _rows(self, result: Diagnosis) -> list[dict[str, object]]:
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
            for finding in result.findings
        ]

    def _figure(self, result: Diagnosis) -> Mapping[str, object]:
        from damper_estimator.report import ranking_figure

        return ranking_figure(result.ranking, result.findings, {})


def diagnose(
    recording: Recording,
    model: ModelLike,
    *,
    validate: Recording | None = None,
    mode: str = "both",
    workers: int = 1,
    progress: Progress | None = None,
) -> DiagnosisResults:
    """Adds each effect that represents a phenomenon to the model and judges it on recordings it was not fitted to.

    Args:
        recording: the measurements; dampers without a force are left out.
        model: the one to improve on: a name of the library, a model file, a folder with one ``DAMPER.yaml`` each, a
            model, or a mapping of these by damper.
        validate: recordings to judge on; None reserves 40 % of each recording.
        mode: ``kept`` judges each effect with the model's parameters unchanged (the model was right before: what has
            changed?), ``refit`` refits them together with the effect, ``both`` does both and reports disagreements.
        workers: number of processes.
        progress: receives the current activity and the completed share of the work, 0 to 1.

    Raises:
        InputError: without a measured force, for an unusable model, and for too few samples.
    """
    check_mode(mode)
    cases = diagnosis_cases(recording, model, validate, "diagnose")
    return DiagnosisResults(
        cases.request,
        {case.damper: diagnose_case(case, mode, workers, progress or no_progress) for case in cases.cases},
    )


def diagnose_case(case: Case, mode: str, workers: int, progress: Progress) -> Diagnosis:
    """The diagnosis of one damper."""
    return diagnosed(case.model, case.fit, case.unseen, mode=mode, workers=workers, progress=progress)
