"""``fleet fit --joint``: one model per damper, or per vehicle and damper, identified on all its recordings together."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from distributed import Client

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.files import json_text, write_text
from damper_estimator.fleet.distributed_fit import fit_distributed
from damper_estimator.fleet.manifest import Recording
from damper_estimator.fleet.task import Task, digest
from damper_estimator.fleet.verbs import Fit
from damper_estimator.fleet.worker_recordings import Source
from damper_estimator.identification import Fit as Fitted
from damper_estimator.model import load_model
from damper_estimator.workflows import fit_record, save_fit

MODELS = "models"


@dataclass(frozen=True)
class JointModel:
    """The result for one model.

    Attributes:
        name: of the damper, preceded by the vehicle if each vehicle has its own models.
        target: the model's file.
        fit: None if nothing has changed since the last identification.
        left_out: unusable recordings, each with the reason.
    """

    name: str
    target: Path
    fit: Fitted | None
    left_out: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class JointFits:
    """Joint fits into the folder ``output``/models.

    Attributes:
        how: options of the identification.
        by_vehicle: whether each vehicle has its own models.
        source: the argument that named the recordings, for errors.
        progress: receives a line from time to time.
    """

    how: Fit
    output: Path
    by_vehicle: bool
    source: str
    progress: Callable[[str], None]

    def models(self, client: Client, tasks: Sequence[Task]) -> list[JointModel]:
        """Identifies every model that is missing or whose inputs have changed.

        Args:
            tasks: one for each recording and damper.

        Raises:
            InputError: if a model cannot be identified on any of its recordings.
        """
        groups: dict[Path, list[Task]] = {}
        for task in tasks:
            if task.damper:
                groups.setdefault(self._folder(task.facts["vehicle"]) / f"{task.damper}.yaml", []).append(task)
        if not groups:
            raise InputError(f"{self.source}: no recording can be used; fleet compare shows why")
        return [self._identified(client, target, group) for target, group in sorted(groups.items())]

    def with_models(self, recordings: Sequence[Recording]) -> list[Recording]:
        """The recordings, each with its identified models."""
        return [replace(recording, model=str(self._folder(recording.vehicle))) for recording in recordings]

    def _folder(self, vehicle: object) -> Path:
        folder = self.output.absolute() / MODELS
        return folder / str(vehicle).replace("/", "_") if self.by_vehicle else folder

    def _identified(self, client: Client, target: Path, tasks: Sequence[Task]) -> JointModel:
        name = f"{target.parent.name} {target.stem}" if self.by_vehicle else target.stem
        kept = target.with_suffix(".fit.json")
        checksums = sorted((t.facts["recording_checksum"], t.facts["signals_checksum"]) for t in tasks)
        given = sorted({t.facts["model_checksum"] for t in tasks})
        fingerprint = digest([list(self.how.words), checksums, given, __version__])
        if target.is_file() and _fingerprint_of(kept) == fingerprint:
            return JointModel(name, target, None)
        if len(given) > 1:
            raise InputError(f"{name}: its recordings name different models; a joint fit starts from a single one")
        self.progress(f"{name}: fitting to {len(tasks)} recordings")
        how, model = self.how.how, load_model(tasks[0].model, tasks[0].damper)
        fit, refused = fit_distributed(
            client, model, [self._source(task) for task in tasks], how.free, how.fix, how.method,
            how.method_options(self.progress), how.limits,
        )  # fmt: skip
        save_fit(fit, target)
        left_out = tuple((source.recording, reason) for source, reason in refused.items())
        listed = [{"recording": recording, "reason": reason} for recording, reason in left_out]
        write_text(kept, json_text({"fingerprint": fingerprint, "left_out": listed, **fit_record(fit, target)}))
        return JointModel(name, target, fit, left_out)

    def _source(self, task: Task) -> Source:
        start = self.how.start or 0.0
        stop = float("inf") if self.how.stop is None else self.how.stop
        return Source(task.recording, task.damper, task.signals, start, stop, str(task.facts["recording_checksum"]))


def _fingerprint_of(kept: Path) -> object:
    try:
        return json.loads(kept.read_text(encoding="utf-8")).get("fingerprint")
    except (OSError, ValueError):
        return None
