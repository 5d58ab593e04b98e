"""Diagnoses, adds missing effects and refits until unseen data justify no further change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damper_estimator.diagnosis import Improvement, Step
from damper_estimator.diagnosis import improve as improved
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, save_model
from damper_estimator.signals import DamperSignals, SignalMap
from damper_estimator.workflows.cases import Case, Progress, check_mode, diagnosis_cases, no_progress
from damper_estimator.workflows.fitting import output_paths
from damper_estimator.workflows.model_arguments import HoldsModels, ModelLike
from damper_estimator.workflows.recording import Recording, in_words
from damper_estimator.workflows.results import Results

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


@dataclass(frozen=True, repr=False, eq=False)
class ImprovementResults(Results[Improvement], HoldsModels):
    """Improved models and the steps to them, by damper.

    The properties are those of one damper (``result["front_left"]`` selects one of several).

    Attributes:
        signal_map: the one in use, with an entry for every damper of the recordings.
    """

    signal_map: SignalMap

    @property
    def improvement(self) -> Improvement:
        """The complete improvement of one damper."""
        return self.only

    @property
    def model(self) -> DamperModel:
        """The improved model."""
        return self.only.model

    @property
    def models(self) -> dict[str, DamperModel]:
        """The improved models of all dampers by name."""
        return {damper: result.model for damper, result in self.by_damper.items()}

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps in order; the first is the start model."""
        return self.only.steps

    @property
    def verdict(self) -> str:
        """Verdict on the error that remains after the last step."""
        return self.only.verdict

    @property
    def sentence(self) -> str:
        """The outcome in one sentence."""
        return self.only.sentence

    @property
    def signals(self) -> DamperSignals:
        """The damper's entry of the signal map, with corrections of the measurement chain, if any."""
        return self.only.signals

    def corrected_map(self) -> SignalMap:
        """The signal map with the corrections of the measurement chain; ``save_signal_map`` writes it."""
        corrected = self.signal_map
        for damper, result in self.by_damper.items():
            corrected = corrected.with_entry(damper, result.signals)
        return corrected

    def curves_figure(self, damper: str | None = None) -> Figure:
        """What the improved model still lacks, as ``DiagnosisResults.curves_figure`` draws it.

        Raises:
            InputError: if there are several dampers and none is named, or the name is unknown.
        """
        from damper_estimator.report import command_unit, curves_figure, plotly_figure

        final = self._of(damper).final
        return plotly_figure(curves_figure(final.curves, command_unit(final)))

    def page(self) -> str:
        """One self-contained HTML page: error over the steps, effects tried at each, forces before and after."""
        from damper_estimator.report import improvement_page, improvement_section

        sections = [improvement_section(damper, result) for damper, result in self.by_damper.items()]
        return improvement_page(sections, f"{self.request['model']} improved on {in_words(self.request['bags'])}")

    def save(self, path: str | Path) -> Path:
        """Writes the model (``.yaml``; several dampers: a folder), the record (``.json``) or the page (``.html``).

        Raises:
            InputError: for another file extension, and if it cannot be written.
        """
        path = Path(path)
        if path.suffix in (".json", ".html"):
            return super().save(path)
        if path.suffix and path.suffix not in (".yaml", ".yml"):
            raise InputError(f"{path}: cannot hold a model; choose a name ending in .yaml, or a folder")
        for damper, target in output_paths(path, list(self)).items():
            target.parent.mkdir(parents=True, exist_ok=True)
            save_model(self.by_damper[damper].model, target)
        return path

    def _record(self, result: Improvement) -> dict[str, object]:
        return improvement_record(result, None, ())

    def _title(self) -> str:
        return "; ".join(f"{damper}: {result.sentence}" for damper, result in self.by_damper.items())

    def _line(self, result: Improvement) -> str:
        first, last = result.steps[0], result.steps[-1]
        added = ", ".join(step.effect for step in result.steps if step.action == "add" and step.effect)
        return f"{first.rmse_unseen_n:.4g} -> {last.rmse_unseen_n:.4g} N rms unseen{'; added ' if added else ''}{added}"

    def _rows(self, result: Improvement) -> list[dict[str, object]]:
        names = ("action", "effect", "phenomenon", "rmse_fit_n", "rmse_unseen_n")
        return [{name: getattr(step, name) for name in names} for step in result.steps]

    def _figure(self, result: Improvement) -> Mapping[str, object]:
        from damper_estimator.report import waterfall_figure

        return waterfall_figure(result)


def improve(
    recording: Recording,
    model: ModelLike,
    *,
    validate: Recording | None = None,
    mode: str = "both",
    workers: int = 1,
    progress: Progress | None = None,
) -> ImprovementResults:
    """Adds missing effects to a model one after the other, and removes those that a later one makes unnecessary.

    Args:
        recording, model, validate, mode, workers, progress: as in ``diagnose``.

    Raises:
        InputError: as ``diagnose``.
    """
    check_mode(mode)
    cases = diagnosis_cases(recording, model, validate, "improve")
    found = {case.damper: improve_case(case, mode, workers, progress or no_progress) for case in cases.cases}
    return ImprovementResults(cases.request, found, cases.signal_map)


def improve_case(case: Case, mode: str, workers: int, progress: Progress) -> Improvement:
    """The improvement of one damper's model."""
    return improved(case.model, case.fit, case.unseen, mode=mode, workers=workers, progress=progress)


def improvement_record(found: Improvement, target: Path | None, steps: tuple[Path, ...]) -> dict[str, object]:
    """An improvement for JSON, with the files that it was written to, if any."""
    from damper_estimator.report import correction_rows

    record: dict[str, Any] = {
        "model": found.model.name,
        "file": target,
        **found.record(),
        "corrections": correction_rows(found),
    }
    if steps:
        record["steps"] = [{**step, "file": path} for step, path in zip(record["steps"], steps, strict=True)]
    return record
