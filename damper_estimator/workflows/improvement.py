"""Diagnose, add what is missing, refit, until nothing more is justified on data that the fit never saw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from damper_estimator.diagnosis import Improvement, Step
from damper_estimator.diagnosis import improve as improved
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, save_model
from damper_estimator.signals import DamperSignals, SignalMap
from damper_estimator.workflows.fitting import output_paths
from damper_estimator.workflows.judging import Case, Tell, check_mode, judging_of, silent
from damper_estimator.workflows.models import HoldsModels, ModelLike
from damper_estimator.workflows.recording import Recording, in_words
from damper_estimator.workflows.results import Results


@dataclass(frozen=True, repr=False, eq=False)
class ImprovementResults(Results[Improvement], HoldsModels):
    """Improved models and the steps to them, by damper.

    For one damper (``result["front_left"]`` where there are several) its model and steps are at hand.

    Attributes:
        signal_map: as it was used, with an entry for every damper of the recordings.
    """

    signal_map: SignalMap

    @property
    def improvement(self) -> Improvement:
        """All that was done for one damper."""
        return self.only

    @property
    def model(self) -> DamperModel:
        """The improved model."""
        return self.only.model

    @property
    def models(self) -> dict[str, DamperModel]:
        """The improved models of all dampers by name."""
        return {damper: own.model for damper, own in self.by_damper.items()}

    @property
    def steps(self) -> tuple[Step, ...]:
        """What was done in order; the first is the model as given."""
        return self.only.steps

    @property
    def verdict(self) -> str:
        """Of what is left after the last step."""
        return self.only.verdict

    @property
    def sentence(self) -> str:
        """What happened, in one sentence."""
        return self.only.sentence

    @property
    def signals(self) -> DamperSignals:
        """The damper's entry of the signal map, corrected where the measurement chain was at fault."""
        return self.only.signals

    def corrected_map(self) -> SignalMap:
        """The signal map with the corrections of the measurement chain; ``save_signal_map`` writes it."""
        corrected = self.signal_map
        for damper, own in self.by_damper.items():
            corrected = corrected.with_entry(damper, own.signals)
        return corrected

    def page(self) -> str:
        """One self-contained HTML page: the error over the steps, what was tried at each, forces before and after."""
        from damper_estimator.report import improvement_page, improvement_section

        sections = [improvement_section(damper, own) for damper, own in self.by_damper.items()]
        return improvement_page(sections, f"{self.asked['model']} improved on {in_words(self.asked['bags'])}")

    def save(self, path: str | Path) -> Path:
        """Writes the model (``.yaml``; several dampers: a folder), the record (``.json``) or the page (``.html``).

        Raises:
            InputError: for another ending, and where it cannot be written.
        """
        path = Path(path)
        if path.suffix in (".json", ".html"):
            return super().save(path)
        if path.suffix and path.suffix not in (".yaml", ".yml"):
            raise InputError(f"{path}: cannot hold a model; give a name that ends in .yaml, or a folder")
        for damper, target in output_paths(path, list(self)).items():
            target.parent.mkdir(parents=True, exist_ok=True)
            save_model(self.by_damper[damper].model, target)
        return path

    def _record(self, own: Improvement) -> dict[str, object]:
        return improvement_record(own, None, ())

    def _title(self) -> str:
        return "; ".join(f"{damper}: {own.sentence}" for damper, own in self.by_damper.items())

    def _line(self, own: Improvement) -> str:
        first, last = own.steps[0], own.steps[-1]
        added = ", ".join(step.effect for step in own.steps if step.action == "add" and step.effect)
        return f"{first.rmse_unseen_n:.4g} -> {last.rmse_unseen_n:.4g} N rms unseen{'; added ' if added else ''}{added}"

    def _rows(self, own: Improvement) -> list[dict[str, object]]:
        names = ("action", "effect", "phenomenon", "rmse_fit_n", "rmse_unseen_n")
        return [{name: getattr(step, name) for name in names} for step in own.steps]

    def _figure(self, own: Improvement) -> Mapping[str, object]:
        from damper_estimator.report import waterfall_figure

        return waterfall_figure(own)


def improve(
    recording: Recording,
    model: ModelLike,
    *,
    validate: Recording | None = None,
    mode: str = "both",
    workers: int = 1,
    progress: Tell | None = None,
) -> ImprovementResults:
    """Adds to a model what is missing, one effect after the other, and takes out again what became needless.

    Args:
        recording, model, validate, mode, workers, progress: as in ``diagnose``.

    Raises:
        InputError: as ``diagnose``.
    """
    check_mode(mode)
    given = judging_of(recording, model, validate, "improve")
    found = {case.damper: improve_case(case, mode, workers, progress or silent) for case in given.cases}
    return ImprovementResults(given.asked, found, given.signal_map)


def improve_case(case: Case, mode: str, workers: int, tell: Tell) -> Improvement:
    """The improvement of one damper's model."""
    return improved(case.model, case.fit, case.unseen, mode=mode, workers=workers, progress=tell)


def improvement_record(found: Improvement, target: Path | None, steps: tuple[Path, ...]) -> dict[str, object]:
    """An improvement for JSON, with the files that it was written to, where it was."""
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
