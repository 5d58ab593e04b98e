"""Identification: finds the parameters with which a model agrees best with measurements."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

from damper_estimator.diagnosis import with_misfit
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.identification import Fit, FittedParameter, Front, MethodOptions
from damper_estimator.identification import fit as identified
from damper_estimator.model import DamperModel, save_model
from damper_estimator.signals import Measurement
from damper_estimator.workflows.model_arguments import HoldsModels, ModelLike, model_name, models_for
from damper_estimator.workflows.recording import Recording, checked
from damper_estimator.workflows.results import Results

Limits = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class FitOptions:
    """Options of an identification.

    Attributes:
        free: addresses or patterns of parameters to identify although the model fixes them.
        fix: parameters to keep; ``free`` overrides ``fix``.
        limits: lowest and highest value by address, narrower than the declared bounds.
        method: one of ``damper_estimator.identification.all_methods()``.
        seed: of the random start values.
        groups: for several objectives, recordings by the objective's name; empty forms groups from the recordings.
        pick: the point of the front that becomes the model: ``knee``, a group's name, or a number.
        front: points from an earlier search, to pick from without a new one.
        population, generations: of evolutionary methods; None for the method's default.
    """

    free: tuple[str, ...] = ()
    fix: tuple[str, ...] = ()
    limits: Limits | None = None
    method: str = "least_squares"
    seed: int = 0
    groups: Mapping[str, tuple[str, ...]] | None = None
    pick: str = "knee"
    front: Front | None = None
    population: int | None = None
    generations: int | None = None

    def method_options(self, progress: Callable[[str], None]) -> MethodOptions:
        """The options in the form that the methods accept."""
        return MethodOptions(
            seed=self.seed, progress=progress, groups=self.groups or {}, pick=self.pick, front=self.front,
            generations=self.generations, population=self.population,
        )  # fmt: skip


@dataclass(frozen=True)
class ModelFitted:
    """One damper: the start model, the fit, and its recordings."""

    start: DamperModel
    fit: Fit
    measurements: tuple[Measurement, ...]


@dataclass(frozen=True, repr=False, eq=False)
class FitResults(Results[ModelFitted], HoldsModels):
    """Identified models with their uncertainty, by damper.

    The properties are those of one damper (``result["front_left"]`` selects one of several).
    """

    @property
    def model(self) -> DamperModel:
        """The model with the identified values."""
        return self.fit.model

    @property
    def models(self) -> dict[str, DamperModel]:
        """The models of all dampers by name."""
        return {damper: result.fit.model for damper, result in self.by_damper.items()}

    @property
    def fit(self) -> Fit:
        """The complete fit of one damper."""
        return self.only.fit

    @property
    def parameters(self) -> tuple[FittedParameter, ...]:
        """The identified parameters with standard errors."""
        return self.fit.parameters

    @property
    def rmse_n(self) -> float:
        """rms error in band over the recordings that were fitted to, N."""
        return self.fit.rmse_n

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the result, one sentence each."""
        return self.fit.warnings

    def save(self, path: str | Path) -> Path:
        """Writes the model (``.yaml``; several dampers: a folder of ``DAMPER.yaml``), or the record (``.json``).

        Raises:
            InputError: for another file extension, and if it cannot be written.
        """
        path = Path(path)
        if path.suffix == ".json":
            return super().save(path)
        if path.suffix and path.suffix not in (".yaml", ".yml"):
            raise InputError(f"{path}: cannot hold a model; choose a name ending in .yaml, or a folder")
        for damper, target in output_paths(path, list(self)).items():
            save_fit(self.by_damper[damper].fit, target)
        return path

    def _record(self, result: ModelFitted) -> dict[str, object]:
        return fit_record(result.fit, None)

    def _line(self, result: ModelFitted) -> str:
        fit = result.fit
        return f"{fit.model.name}, {len(fit.parameters)} parameters, {fit.rmse_before_n:.4g} -> {fit.rmse_n:.4g} N rms"

    def _rows(self, result: ModelFitted) -> list[dict[str, object]]:
        return [asdict(parameter) for parameter in result.fit.parameters]

    def _figure(self, result: ModelFitted) -> Mapping[str, object]:
        from damper_estimator.report import forces_figure
        from damper_estimator.validation import compare as compared

        models = (replace(result.start, name=f"{result.start.name} as given"), result.fit.model)
        return forces_figure([compared(model, *result.measurements) for model in models])


def fit(
    recording: Recording,
    model: ModelLike,
    *,
    free: str | Iterable[str] = (),
    fix: str | Iterable[str] = (),
    limits: Limits | None = None,
    method: str = "least_squares",
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> FitResults:
    """Identifies a model's free parameters, for each damper on all its recordings together.

    Args:
        recording: the measurements; dampers without a force are left out.
        model: the start model: a name of the library, a model file, a folder with one ``DAMPER.yaml`` each, a model,
            or a mapping of these by damper.
        free, fix: addresses such as ``coulomb.force``, whole effects, or patterns with ``*`` and ``?``: to identify
            although the model fixes them, and to keep; ``free`` overrides ``fix``.
        limits: lowest and highest value by address.
        method: ``least_squares``, or another that ``damper-estimator fit --help`` lists.
        seed: of the random start values; equal seeds give equal results.
        progress: receives a line from time to time.

    Raises:
        InputError: without a measured force, for an unusable model, and for too few samples.
    """
    options = FitOptions(_names(free), _names(fix), limits, method, seed)
    return fit_with(recording, model, options, progress or _no_progress)


def fit_with(
    recording: Recording, model: ModelLike, options: FitOptions, progress: Callable[[str], None]
) -> FitResults:
    """``fit`` with all options; ``progress`` receives a line from time to time."""
    measured = checked(recording).with_force("fit")
    models = models_for(model, measured.dampers)
    found = {}
    for damper, measurements in measured.measurements.items():
        start, count = models[damper], len(measurements)
        progress(f"{damper}: fitting {start.name} to {count} recording{'s' if count > 1 else ''}")
        fitted = identified(
            start, measurements, options.free, options.fix, options.method, options.seed,
            method_options=options.method_options(progress), limits=options.limits,
        )  # fmt: skip
        fitted = replace(fitted, model=with_misfit(fitted.model, measurements))
        found[damper] = ModelFitted(start, fitted, measurements)
    return FitResults({"bags": list(recording.names), "model": model_name(model)}, found)


def _names(given: str | Iterable[str]) -> tuple[str, ...]:
    return (given,) if isinstance(given, str) else tuple(given)


def fit_record(fit: Fit, target: Path | None) -> dict[str, object]:
    """A fit for JSON: the fields of ``Fit``, with the model's name and file (None if it was not written)."""
    plain = {
        field.name: getattr(fit, field.name)
        for field in fields(fit)
        if field.name not in ("model", "parameters", "front")
    }
    if fit.front is not None:
        plain["front"] = _front_record(fit.front, target)
    return {"model": fit.model.name, "file": target, **plain, "parameters": [asdict(p) for p in fit.parameters]}


def _front_record(front: Front, target: Path | None) -> dict[str, object]:
    return {
        "file": None if target is None else target.with_suffix(".front.csv"),
        "picked": front.picked,
        "knee": front.row("knee"),
        "groups": list(front.groups),
        "excitations": list(front.excitations),
        "parameters": list(front.names),
        "values": front.values,
        "objectives": front.objectives,
        "regimes": front.regimes(),
    }


def save_fit(fit: Fit, target: Path) -> None:
    """Writes the model, and its front, if any, next to it.

    Raises:
        InputError: if it cannot be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    save_model(fit.model, target)
    if fit.front is not None:
        from damper_estimator.report import front_page

        front = fit.front
        write_text(target.with_suffix(".front.csv"), front.as_csv())
        page = front_page(fit.model.name, front.groups, front.objectives, front.picked, front.regimes())
        write_text(target.with_suffix(".front.html"), page)


def output_paths(output: Path, dampers: Sequence[str]) -> dict[str, Path]:
    """Target file for each damper's model: in the folder ``output``, or the file ``output`` if there is one damper.

    Raises:
        InputError: for one file and several dampers.
    """
    if output.is_dir() or (len(dampers) > 1 and output.suffix not in (".yaml", ".yml")):
        return {damper: output / f"{damper}.yaml" for damper in dampers}
    if len(dampers) > 1:
        raise InputError(
            f"{output}: is one file, but there are several dampers ({', '.join(dampers)}); name a folder or use -d"
        )
    return {dampers[0]: output}


def _no_progress(text: str) -> None:
    """Discards progress lines."""
