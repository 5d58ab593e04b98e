"""Compares models with the measured force: how well they agree, and where they fail."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from damper_estimator.model import DamperModel
from damper_estimator.validation import (
    Comparison,
    JudgedStep,
    Region,
    partial_coherence,
    per_recording,
    step_check,
    velocity_agreement,
)
from damper_estimator.validation import (
    compare as compared,
)
from damper_estimator.workflows.model_arguments import ModelLike, model_for, model_name
from damper_estimator.workflows.recording import Recording, checked, in_words
from damper_estimator.workflows.results import Results

if TYPE_CHECKING:
    from damper_estimator.report import Section

Groups = Mapping[str, Sequence[str]]
"""Recordings by the name of their group."""


@dataclass(frozen=True)
class ModelsCompared:
    """One damper: the comparison of each model with its recordings.

    Attributes:
        comparisons: one per model, on the same measurements.
        models: as given by the caller.
        steps: results for every step of the recordings by model; None if not requested.
    """

    comparisons: tuple[Comparison, ...]
    models: tuple[object, ...]
    steps: Mapping[str, Sequence[Mapping[str, object]]] | None = None

    def record(self) -> dict[str, object]:
        """For JSON: the first model's results, with those of all models in ``models`` and of each bag in ``bags``."""
        records = []
        for comparison, model in zip(self.comparisons, self.models, strict=True):
            record = comparison.record() | {"model_file": model}
            if len(comparison.traces) > 1:
                record["bags"] = [part.record() | {"bag": part.recordings[0]} for part in per_recording(comparison)]
            records.append(record)
        measurements = [t.measurement for t in self.comparisons[0].traces]
        velocities = {
            m.recording: agreement.record() for m in measurements if (agreement := velocity_agreement(m)) is not None
        }
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

    The properties are the first model's values for one damper (``result["front_left"]`` selects one of several).
    """

    bags_in_words: str = field(default="")

    @property
    def comparison(self) -> Comparison:
        """The first model's comparison with all its numbers and traces."""
        return self.only.comparisons[0]

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """The comparisons of all models."""
        return self.only.comparisons

    @property
    def rmse_n(self) -> float:
        """rms of modelled minus measured force in band, N."""
        return self.comparison.measures.rmse_n

    @property
    def esr(self) -> float:
        """Variance of the error over that of the measured force."""
        return self.comparison.measures.esr

    @property
    def noise_floor_n(self) -> float:
        """The error that even a perfect model has on these recordings, N."""
        return self.comparison.noise_floor_n

    @property
    def regions(self) -> tuple[Region, ...]:
        """Regions of operation with a large error, worst first."""
        return self.comparison.regions

    def page(self) -> str:
        """One self-contained HTML page: forces over time, where the model fails, data quality."""
        from damper_estimator.report import comparison_page, damper_section

        sections = [damper_section(result.comparisons, len(self)) for result in self.by_damper.values()]
        return comparison_page(sections, page_title(sections, self.bags_in_words))

    def _record(self, result: ModelsCompared) -> dict[str, object]:
        return result.record()

    def _line(self, result: ModelsCompared) -> str:
        return ", ".join(
            f"{c.model.name} {c.measures.rmse_n:.4g} N rms ({100 * c.measures.nrmse:.1f} % of the force)"
            for c in result.comparisons
        )

    def _rows(self, result: ModelsCompared) -> list[dict[str, object]]:
        return [
            {"model": c.model.name, **c.measures.record(), "noise_floor_n": c.noise_floor_n} for c in result.comparisons
        ]

    def _figure(self, result: ModelsCompared) -> Mapping[str, object]:
        from damper_estimator.report import forces_figure

        return forces_figure(result.comparisons)


def compare(
    recording: Recording,
    model: ModelLike | Sequence[ModelLike],
    *,
    groups: Groups | None = None,
    steps: bool = False,
) -> ComparisonResults:
    """Judges models against the measured force; both pass the same filters (docs/python.md names the measures).

    Args:
        recording: the measurements; dampers without a force are left out.
        model: one or several to be compared with each other: a name of the library, a model file, a folder with one
            ``DAMPER.yaml`` each, a model, or a mapping of these by damper.
        groups: names of groups with their recordings; None groups by velocity and frequency.
        steps: judge each step of 10 mm or more separately.

    Raises:
        InputError: without a measured force, for an unusable model, and if nothing can be judged.
    """
    models = tuple(model) if isinstance(model, Sequence) and not isinstance(model, str) else (model,)
    measured = checked(recording).with_force("compare")
    named = tuple(model_name(each) for each in models)
    found = {damper: _compared(one, damper, models, named, groups or {}, steps) for damper, one in measured.each()}
    return ComparisonResults(comparison_request(recording.names, named), found, in_words(recording.names))


def comparison_request(bags: Sequence[str], models: Sequence[object]) -> dict[str, object]:
    """The inputs of a comparison, for its JSON results."""
    return {"bags": list(bags), "models": list(models)}


def page_title(sections: Sequence[Section], bags: str) -> str:
    """Title of a page made of sections from ``damper_section``."""
    models: list[str] = sections[0].figures["models"]  # type: ignore[assignment]  # figures are JSON
    return f"{' and '.join(models)} against {bags}"


def _compared(
    one: Recording, damper: str, models: Sequence[ModelLike], named: tuple[object, ...], groups: Groups, steps: bool
) -> ModelsCompared:
    measurements = one.measurements[damper]
    judged = [compared(model, *measurements) for model in _distinct([model_for(model, damper) for model in models])]
    comparisons = tuple(replace(comparison, grouping=groups) for comparison in judged)
    steps_by_model = {c.model.name: _steps(c) for c in comparisons} if steps else None
    return ModelsCompared(comparisons, named, steps_by_model)


def _distinct(models: Sequence[DamperModel]) -> list[DamperModel]:
    """The models, numbered where several have the same name."""
    count = Counter(model.name for model in models)
    number: Counter[str] = Counter()
    found = []
    for model in models:
        number[model.name] += 1
        name = f"{model.name} ({number[model.name]})" if count[model.name] > 1 else model.name
        found.append(replace(model, name=name))
    return found


def _steps(comparison: Comparison) -> list[dict[str, object]]:
    return [
        step_record(step, t.measurement.recording)
        for t in comparison.traces
        for step in step_check(comparison.model, t.measurement)
    ]


def step_record(step: JudgedStep, recording: str) -> dict[str, object]:
    """A model's result for one step, for JSON."""
    return {
        "bag": recording,
        "time_s": step.time,
        "seconds": step.seconds,
        "height_m": step.height,
        "peak_velocity": step.peak_velocity,
        **step.measures.record(),
    }
