"""How well models agree with what was measured, and where they fail."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from damper_estimator.validation import (
    Comparison,
    Region,
    Step,
    partial_coherence,
    per_recording,
    step_check,
    velocity_agreement,
)
from damper_estimator.validation import (
    compare as compared,
)
from damper_estimator.workflows.models import ModelLike, model_for, model_name
from damper_estimator.workflows.recording import Recording, checked, in_words
from damper_estimator.workflows.results import Results

if TYPE_CHECKING:
    from damper_estimator.report import Section

Groups = Mapping[str, Sequence[str]]
"""Recordings by the name of their group."""


@dataclass(frozen=True)
class ModelsCompared:
    """One damper: what each model makes of it.

    Attributes:
        comparisons: one per model, on the same measurements.
        models: as they were asked for.
        steps: by model, what it makes of every step of the recordings; None where that was not asked.
    """

    comparisons: tuple[Comparison, ...]
    models: tuple[object, ...]
    steps: Mapping[str, Sequence[Mapping[str, object]]] | None = None

    def record(self) -> dict[str, object]:
        """The first model's record; all under ``models``, and where there are several bags each under ``bags``."""
        records = []
        for comparison, model in zip(self.comparisons, self.models, strict=True):
            record = comparison.record() | {"model_file": model}
            if len(comparison.traces) > 1:
                record["bags"] = [own.record() | {"bag": own.recordings[0]} for own in per_recording(comparison)]
            records.append(record)
        measurements = [t.measurement for t in self.comparisons[0].traces]
        velocities = {m.recording: own.record() for m in measurements if (own := velocity_agreement(m)) is not None}
        return (
            records[0]
            | {"partial_coherence": partial_coherence(measurements).record()}
            | ({"velocity": velocities} if velocities else {})
            | ({"models": records} if len(records) > 1 else {})
            | ({"steps": dict(self.steps)} if self.steps is not None else {})
        )


@dataclass(frozen=True, repr=False, eq=False)
class ComparisonResults(Results[ModelsCompared]):
    """How well one or several models agree with the measured force, by damper.

    For one damper (``result["front_left"]`` where there are several) the first model's numbers are at hand.
    """

    bags_in_words: str = field(default="")

    @property
    def comparison(self) -> Comparison:
        """The first model's comparison with all its numbers and traces."""
        return self.only.comparisons[0]

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Those of all models."""
        return self.only.comparisons

    @property
    def rmse_n(self) -> float:
        """rms of modelled less measured force in band, N."""
        return self.comparison.measures.rmse_n

    @property
    def esr(self) -> float:
        """Variance of the error over that of the measured force."""
        return self.comparison.measures.esr

    @property
    def noise_floor_n(self) -> float:
        """The error that a perfect model would still show on these recordings, N."""
        return self.comparison.noise_floor_n

    @property
    def regions(self) -> tuple[Region, ...]:
        """Where in the operation the error is, worst first."""
        return self.comparison.regions

    def page(self) -> str:
        """One self-contained HTML page: forces over time, where the model fails, data quality."""
        from damper_estimator.report import comparison_page, damper_section

        sections = [damper_section(own.comparisons, len(self)) for own in self.by_damper.values()]
        return comparison_page(sections, page_title(sections, self.bags_in_words))

    def _record(self, own: ModelsCompared) -> dict[str, object]:
        return own.record()

    def _line(self, own: ModelsCompared) -> str:
        return ", ".join(
            f"{c.model.name} {c.measures.rmse_n:.4g} N rms ({100 * c.measures.nrmse:.1f} % of the force)"
            for c in own.comparisons
        )

    def _rows(self, own: ModelsCompared) -> list[dict[str, object]]:
        return [
            {"model": c.model.name, **c.measures.record(), "noise_floor_n": c.noise_floor_n} for c in own.comparisons
        ]

    def _figure(self, own: ModelsCompared) -> Mapping[str, object]:
        from damper_estimator.report import forces_figure

        return forces_figure(own.comparisons)


def compare(
    recording: Recording,
    model: ModelLike | Sequence[ModelLike],
    *,
    groups: Groups | None = None,
    steps: bool = False,
) -> ComparisonResults:
    """Judges models against the measured force; both pass the same filters (docs/python.md names the measures).

    Args:
        recording: what was measured; dampers without a force are left out.
        model: one, or a list of them to stand side by side: a name of the library, a model file, a folder with one
            ``DAMPER.yaml`` each, a model, or a mapping of these by damper.
        groups: recordings by the name of a group whose error is to be given; None groups by velocity and frequency.
        steps: judge every step of 10 mm and more by itself.

    Raises:
        InputError: one line; without a measured force, for a model that cannot be used, where nothing can be judged.
    """
    models = tuple(model) if isinstance(model, Sequence) and not isinstance(model, str) else (model,)
    measured = checked(recording).with_force("compare")
    named = tuple(model_name(own) for own in models)
    found = {damper: _compared(one, damper, models, named, groups or {}, steps) for damper, one in measured.each()}
    return ComparisonResults(asked(recording.names, named), found, in_words(recording.names))


def asked(bags: Sequence[str], models: Sequence[object]) -> dict[str, object]:
    """What a comparison's record says of what was asked."""
    return {"bags": list(bags), "models": list(models)}


def page_title(sections: Sequence[Section], bags: str) -> str:
    """Title of the page of sections of ``damper_section``."""
    models: list[str] = sections[0].figures["models"]  # type: ignore[assignment]  # what a figure holds is JSON
    return f"{' and '.join(models)} against {bags}"


def _compared(
    one: Recording, damper: str, models: Sequence[ModelLike], named: tuple[object, ...], groups: Groups, steps: bool
) -> ModelsCompared:
    measurements = one.measurements[damper]
    judged = [compared(model_for(model, damper), *measurements) for model in models]
    comparisons = tuple(replace(own, grouping=groups) for own in judged)
    own_steps = {c.model.name: _steps(c) for c in comparisons} if steps else None
    return ModelsCompared(comparisons, named, own_steps)


def _steps(comparison: Comparison) -> list[dict[str, object]]:
    return [
        step_record(step, t.measurement.recording)
        for t in comparison.traces
        for step in step_check(comparison.model, t.measurement)
    ]


def step_record(step: Step, recording: str) -> dict[str, object]:
    """What a model makes of one step, for JSON."""
    return {
        "bag": recording,
        "time_s": step.time,
        "seconds": step.seconds,
        "height_m": step.height,
        "peak_velocity": step.peak_velocity,
        **step.measures.record(),
    }
