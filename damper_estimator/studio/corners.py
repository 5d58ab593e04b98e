"""All dampers of a recording side by side: how well each one's model agrees, where it fails, and what it lacks."""

import multiprocessing
import re
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from damper_estimator.diagnosis import Diagnosis
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.report.theme import COLOURS, LIGHT
from damper_estimator.report.wording import in_signs, measure_text
from damper_estimator.studio.drawn_rows import cloud_rows
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.history import History, Version
from damper_estimator.studio.long_tasks import Change, diagnose_case, improve_case, judged
from damper_estimator.studio.model_run import ModelRun, run_model
from damper_estimator.studio.opening import load_chosen
from damper_estimator.studio.stage import Choice, Stage, opened
from damper_estimator.studio.thumbnail import dots_picture
from damper_estimator.studio.worker_process import Progress
from damper_estimator.workflows import no_progress

TASKS = {"compare": "comparing all", "diagnose": "diagnosing all", "improve": "improving all"}
"""What can be done with all dampers in one go, and the name of that work."""

_MOST_DOTS = 700
_AT_A_TIME = 2


@dataclass(frozen=True)
class Corner:
    """One damper of the overview.

    Attributes:
        damper: its name.
        stage: what was read, without the samples; None where it could not be read.
        history: the versions of its model, the one that was judged last.
        rms, relative: the model's error with its unit.
        worst: the region that carries most of the error, in words.
        verdict: of the diagnosis, in a sentence; "" before there is one.
        diagnosis: of the version on view; None before there is one.
        picture: force over velocity, measured and modelled, as an image's address.
        failed: why there is nothing to see; "" where all is well.
    """

    damper: str
    stage: Stage | None = None
    history: History | None = None
    rms: str = ""
    relative: str = ""
    worst: str = ""
    verdict: str = ""
    diagnosis: Diagnosis | None = None
    picture: str = ""
    failed: str = ""


@dataclass(frozen=True)
class Task:
    """What is to be done with all dampers of recordings.

    Attributes:
        root: of the studio's folder.
        choices: by damper, in the order of the overview.
        model: name of a model file or of a model of the library.
        kind: key of ``TASKS``.
        mode, workers: of the diagnosis.
        histories: by damper, the steps that were made already.
    """

    root: Path
    choices: Mapping[str, Choice]
    model: str
    kind: str
    mode: str
    workers: int
    histories: Mapping[str, History]


def worked_on(task: Task, progress: Progress) -> tuple[Corner, ...]:
    """Does a task, damper by damper; one that cannot be read does not stop the others.

    A comparison uses one processor, so that of two dampers runs at a time; more would need too much memory for long
    recordings. The other tasks use all processors for each damper.
    """
    names = list(task.choices)
    if task.kind == "compare" and min(task.workers, len(names)) > 1:
        return _compared(task, names, progress)
    corners = []
    for i, name in enumerate(names):

        def part(text: str, share: float, i: int = i, name: str = name) -> None:
            progress(f"{name}: {text}", (i + share) / len(names))

        corners.append(_corner_or_reason(task, name, part))
    return tuple(corners)


def _compared(task: Task, names: Sequence[str], progress: Progress) -> tuple[Corner, ...]:
    corners: dict[str, Corner] = {}
    with ProcessPoolExecutor(_AT_A_TIME, mp_context=multiprocessing.get_context("fork")) as pool:
        waiting = {pool.submit(_corner_or_reason, task, name, no_progress): name for name in names}
        for future in as_completed(waiting):
            corners[waiting[future]] = future.result()
            progress(f"{waiting[future]}: compared", len(corners) / len(names))
    return tuple(corners[name] for name in names)


def _corner_or_reason(task: Task, name: str, progress: Progress) -> Corner:
    try:
        return _corner(Folder(task.root), task, name, progress)
    except InputError as error:
        return Corner(name, failed=str(error))


def place(damper: str) -> tuple[bool, bool, str]:
    """Where a damper stands among the others: front before rear, left before right, as seen from above."""
    words = set(re.split(r"[^a-z]+", damper.lower()))
    return bool(words & {"rear", "rl", "rr"}), bool(words & {"right", "fr", "rr"}), damper


def _corner(folder: Folder, task: Task, damper: str, progress: Progress) -> Corner:
    stage = opened(folder, task.choices[damper], lambda text, share: progress(text, 0.2 * share))
    history = task.histories.get(damper) or _begun(stage, load_chosen(folder, task.model, damper))
    found = None

    def later(text: str, share: float) -> None:
        progress(text, 0.3 + 0.7 * share)

    if task.kind == "diagnose":
        case = stage.corrected(history.now.signals).case(history.now.step.model)
        found = diagnose_case(case, task.mode, task.workers, later)
    elif task.kind == "improve":
        history, found = _improved(stage, history, task, later)
    return _summary(stage, history, found)


def _begun(stage: Stage, model: DamperModel) -> History:
    return History((Version(judged(stage.case(model), Change("start")), stage.signals),))


def _improved(stage: Stage, history: History, task: Task, progress: Progress) -> tuple[History, Diagnosis]:
    case = stage.corrected(history.now.signals).case(history.now.step.model)
    found = improve_case(case, task.mode, task.workers, progress)
    for step in found.steps[1:]:
        signals = found.signals if step.action == "correct" else history.now.signals
        history = history.then(Version(step, signals))
    return history, found.final


def _summary(stage: Stage, history: History, found: Diagnosis | None) -> Corner:
    view = run_model(history.now.step.model, stage.corrected(history.now.signals))
    compared = view.comparison()
    record = view.measures.record()
    regions = [in_signs(f"{region.where}: {region.what}") for region in compared.regions[:1]]
    return Corner(
        stage.damper,
        stage.emptied(),
        history,
        f"{measure_text('rmse_n', record['rmse_n'])} N",
        f"{measure_text('nrmse', record['nrmse'])} %",
        regions[0] if regions else "the error is spread evenly over the operation",
        found.sentence if found is not None else "",
        found,
        _picture(view),
    )


def _picture(view: ModelRun) -> str:
    trace = view.traces[0]
    velocity = trace.measurement.kinematics.velocity
    clouds = []
    for force, colour in ((trace.measured, COLOURS[LIGHT]["samples"]), (trace.modelled, COLOURS[LIGHT]["model0"])):
        rows = cloud_rows(velocity, force)
        rows = rows[:: max(rows.size // _MOST_DOTS, 1)]
        clouds.append((velocity[rows], force[rows], colour))
    return dots_picture(clouds)
