"""Diagrams of the open recordings, the next test on a rig, and simulated rides; results go into the studio's folder."""

from collections.abc import Callable

from damper_estimator.diagnosis import Diagnosis
from damper_estimator.errors import InputError
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.rig_tasks import RigTest, characterized, planned, ridden
from damper_estimator.studio.session import Session
from damper_estimator.studio.worker_process import Progress, run_in_process
from damper_estimator.workflows import RIDE_DAMPERS, Tie, library_rigs, ties_of

SHARPEN = "parameters"  # the aim of a test that makes the parameters more certain


def aims(found: Diagnosis | None) -> dict[str, str]:
    """What a test can be planned for: by value, in words; the ties of the diagnosis first."""
    groups = [(one.phenomenon, *one.tied_with) for one in found.findings if one.tied_with] if found else []
    words = {"+".join(group): " or ".join(name.replace("_", " ") for name in group) for group in groups}
    return {value: f"decide: {text}" for value, text in words.items()} | {SHARPEN: "sharpen the model's parameters"}


def characterize(session: Session) -> None:
    """Begins to average the cycles of the open recordings."""
    _begin(session, "characterizing", characterized, (session.here.case(session.model), session.folder.root))


def plan(session: Session, aim: object, rig: object, minutes: object) -> None:
    """Begins to plan a test.

    Raises:
        InputError: for an aim or a rig that is not offered, or a length that is no positive number.
    """
    if aim not in aims(session.diagnosis):
        raise InputError("choose what the test is for; diagnose first to decide between tied explanations")
    if minutes is not None and not (isinstance(minutes, (int, float)) and 0.0 < minutes <= 60.0):
        raise InputError("give the length in minutes, at most 60, or leave it empty")
    if rig not in rigs(session.folder):
        raise InputError("choose a rig")
    path = session.folder.path(rig) if str(rig).endswith((".yaml", ".yml")) else str(rig)
    tie = Tie(()) if aim == SHARPEN else _ties(session.diagnosis)[str(aim)]
    case, root = session.here.case(session.model), session.folder.root
    _begin(session, "planning", planned, (case, tie, path, None if minutes is None else float(minutes), root))


def ride(session: Session, damper: object, seconds: object) -> None:
    """Begins to compare the feed-forward of the current by a model of this structure with a table and a passive damper.

    Raises:
        InputError: for a damper that is not offered, or a drive that is too short or too long.
    """
    if damper not in RIDE_DAMPERS:
        raise InputError("choose a simulated damper")
    if not (isinstance(seconds, (int, float)) and 5.0 <= seconds <= 120.0):
        raise InputError("give the length of a drive in seconds, 5 to 120")
    _begin(session, "riding", ridden, (session.model, str(damper), float(seconds), session.folder.root))


def _ties(found: Diagnosis | None) -> dict[str, Tie]:
    """By the value of the aim."""
    return {"+".join(tie.group): tie for tie in (ties_of(found) if found else ())}


def rigs(folder: Folder) -> list[str]:
    """The library's rigs, and rig files of the folder."""
    return [*library_rigs(), *folder.rigs()]


def _begin(session: Session, name: str, function: Callable[..., RigTest], arguments: tuple) -> None:
    def work(progress: Progress) -> None:
        session.keep_test(run_in_process(function, arguments, progress))

    session.start(name, work)
