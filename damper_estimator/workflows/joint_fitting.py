"""Fits one damper at several settings: some parameters differ between them, all others are shared."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.identification import JointFit, fit_joint, named, settings_by_channel
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, PRESSURE, TEMPERATURE
from damper_estimator.workflows.fitting import FitOptions, fit_record, save_fit
from damper_estimator.workflows.model_arguments import ModelLike, models_for
from damper_estimator.workflows.recording import Recording

CHANNELS = {"command": COMMAND, "temperature": TEMPERATURE, "pressure": PRESSURE}
Settings = str | Mapping[str, Sequence[str]]
"""The channel that determines the setting of each recording, or the recordings of each setting."""


@dataclass(frozen=True)
class JointlyFitted:
    """The joint fits by damper; saved as one model per setting."""

    fits: Mapping[str, JointFit]

    def folders(self, output: Path) -> dict[str, Path]:
        """Folder for the models of each damper."""
        return {damper: output / damper if len(self.fits) > 1 else output for damper in self.fits}

    def save(self, output: Path) -> None:
        """Writes one model per setting.

        Raises:
            InputError: if one cannot be written.
        """
        for damper, folder in self.folders(output).items():
            for setting, fit in self.fits[damper].fits.items():
                save_fit(fit, folder / f"{setting}.yaml")

    def records(self, output: Path) -> dict[str, dict[str, object]]:
        """For JSON: one fit per setting, and all parameters once."""
        return {damper: _record(self.fits[damper], folder) for damper, folder in self.folders(output).items()}


def fit_jointly(
    recording: Recording,
    model: ModelLike,
    each: Sequence[str],
    settings: Settings,
    options: FitOptions,
    progress: Callable[[str], None],
) -> JointlyFitted:
    """Identifies a model on all recordings together, some parameters by setting.

    Args:
        each: parameters that differ between the settings.
        settings: the setting of each recording.
        progress: receives a line from time to time.

    Raises:
        InputError: as ``fit``, and for a recording in no setting or in several.
    """
    measured = recording.with_force("fit")
    models = models_for(model, measured.dampers)
    found = {}
    for damper, measurements in measured.measurements.items():
        chosen = _settings(settings, measurements)
        progress(
            f"{damper}: fitting {models[damper].name} to {len(measurements)} recordings, {len(set(chosen))} settings"
        )
        found[damper] = fit_joint(
            models[damper], measurements, chosen, each, options.free, options.fix, options.method, options.seed,
            method_options=options.method_options(progress), limits=options.limits,
        )  # fmt: skip
    return JointlyFitted(found)


def _settings(given: Settings, measurements: Sequence[Measurement]) -> list[str]:
    """The setting of each recording."""
    if isinstance(given, str):
        return settings_by_channel(measurements, CHANNELS[given], given)
    settings = []
    for measurement in measurements:
        names = [name for name, bags in given.items() if named(measurement.recording, bags)]
        if len(names) != 1:
            where = f"settings {', '.join(names)}" if names else "no setting"
            raise InputError(f"{measurement.recording}: is in {where}; name it in one --by SETTING=BAG[,BAG]")
        settings += names
    return settings


def _record(result: JointFit, folder: Path) -> dict[str, object]:
    return {
        "each": list(result.each),
        "settings": {name: fit_record(fit, folder / f"{name}.yaml") for name, fit in result.fits.items()},
        "parameters": [asdict(p) for p in result.parameters],
        "undetermined": result.undetermined,
        "warnings": list(result.warnings),
    }
