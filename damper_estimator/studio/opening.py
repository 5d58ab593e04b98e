"""Reading what a page opens: recordings and models as they were chosen, or a session from its file."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.identification import usable
from damper_estimator.model import DamperModel, library_models, load_model
from damper_estimator.studio.folder import YAML, Folder
from damper_estimator.studio.history import History, Version
from damper_estimator.studio.long_tasks import Change, judged
from damper_estimator.studio.model_run import ModelRun, run_model
from damper_estimator.studio.session_files import SavedSession, history_of
from damper_estimator.studio.stage import Choice, Stage, opened
from damper_estimator.studio.worker_process import Progress


@dataclass(frozen=True)
class Opened:
    """What was read.

    Attributes:
        names: of the models, as they were chosen.
        views: forces of the model on view and of the others.
        saved: versions that are in a model file, and the file's name.
    """

    stage: Stage
    history: History
    others: tuple[DamperModel, ...]
    names: tuple[str, ...]
    views: tuple[ModelRun, ...]
    saved: tuple[tuple[Version, str], ...] = ()


def read_choice(
    folder: Folder, choice: Choice, models: Sequence[str], progress: Progress, history: History | None = None
) -> Opened:
    """Recordings and models as they were chosen; with the steps of a ``history`` where one is given.

    Raises:
        InputError: for what cannot be read or does not go together.
    """
    stage = opened(folder, choice, progress)
    first, *others = (load_chosen(folder, name, stage.damper) for name in models)
    progress(f"running {first.name}", 0.9)
    for measurement in (*stage.fit, *stage.unseen):
        usable(first, measurement)
    if history is None:
        history = History((Version(judged(stage.case(first), Change("start")), stage.signals),))
    return Opened(stage, history, tuple(others), tuple(models), _views(stage, history, others))


def read_session_file(folder: Folder, name: str, kept: SavedSession, step: int | None, progress: Progress) -> Opened:
    """A session from its file, at a step of it; models beside whose files have gone are left out.

    Raises:
        InputError: for recordings that cannot be read, and a damaged file.
    """
    stage = opened(folder, kept.choice, progress)
    history, files = history_of(kept, stage, name)
    if step is not None and 0 <= step < len(history.versions):
        history = replace(history, at=step)
    progress(f"running {history.now.step.model.name}", 0.9)
    others = tuple(load_chosen(folder, model, stage.damper) for model in kept.models[1:] if _is_there(folder, model))
    saved = tuple((version, file) for version, file in zip(history.versions, files, strict=True) if file)
    return Opened(stage, history, others, kept.models, _views(stage, history, others), saved)


def _views(stage: Stage, history: History, others: Sequence[DamperModel]) -> tuple[ModelRun, ...]:
    now = history.now
    return (run_model(now.step.model, stage.corrected(now.signals)), *(run_model(other, stage) for other in others))


def load_chosen(folder: Folder, name: str, damper: str) -> DamperModel:
    """A model of the library, or of a file of the folder, for a damper.

    Raises:
        InputError: for a name that is neither, and a damaged file.
    """
    library = library_models()
    if name in library:
        return load_model(library[name], damper)
    if Path(str(name)).suffix not in YAML:
        raise InputError(f"{name}: is neither a model file nor the name of a model in the library")
    return load_model(folder.existing(name, YAML), damper)


def _is_there(folder: Folder, name: str) -> bool:
    try:
        return name in library_models() or folder.existing(name, YAML).is_file()
    except InputError:
        return False
