"""The work on tests, in a worker process: results are written into a new folder."""

from dataclasses import dataclass
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.model import DamperModel, save_model
from damper_estimator.studio.worker_process import Progress
from damper_estimator.workflows import Case, Tie, characterize_case, plan_case, ride


@dataclass(frozen=True)
class RigTest:
    """One result.

    Attributes:
        title, sentence: what it is, and what it says.
        folder: where it was written, in the studio's folder.
        page: the name of its page there.
        files: the names of the other files there.
        steps: what a test drives, one line each.
    """

    title: str
    sentence: str
    folder: str
    page: str
    files: tuple[str, ...]
    steps: tuple[str, ...] = ()


def characterized(case: Case, root: Path, progress: Progress) -> RigTest:
    """The diagrams, written into a new folder below ``root``: their page, and the structure that follows, if any."""
    progress("averaging cycles", 0.2)
    found = characterize_case(case)
    files: tuple[str, ...] = ()
    target = _new_folder(root, "diagrams")
    if found.characterization.structure is not None:
        save_model(found.structure, target / "structure.yaml")
        files = ("structure.yaml",)
    progress("writing the page", 0.8)
    write_text(target / "diagrams.html", found.page())
    return RigTest(f"diagrams of {case.damper}", found.sentence, target.name, "diagrams.html", files)


def planned(case: Case, tie: Tie, rig: str | Path, minutes: float | None, root: Path, progress: Progress) -> RigTest:
    """The next test, written into a new folder: drive.csv (if the rig can play it), plan.yaml and plan.html."""
    found = plan_case(case, tie, rig, minutes, progress)
    target = _new_folder(root, "test")
    files = found.write(target)
    others = tuple(sorted(file.name for file in files if file.suffix != ".html"))
    steps = tuple(words for _, words in found.plan.listed)
    return RigTest(f"test for {case.damper}", found.sentence, target.name, "plan.html", others, steps)


def ridden(model: DamperModel, damper: str, seconds: float, root: Path, progress: Progress) -> RigTest:
    """The ride with a model of the given structure, written into a new folder: page and identified model."""
    found = ride(model, [damper], seconds=seconds, progress=progress)
    target = _new_folder(root, "ride")
    write_text(target / "ride.html", found.page())
    name = f"{damper}.yaml"
    save_model(found.only.trained.model, target / name)
    return RigTest(f"ride of {model.name} on {damper}", found.sentence, target.name, "ride.html", (name,))


def _new_folder(root: Path, stem: str) -> Path:
    """A folder that did not exist: made when there is something to write, so that two pages never share one.

    Raises:
        InputError: if it cannot be made.
    """
    for number in range(1, 1000):
        target = root / (stem if number == 1 else f"{stem}_{number}")
        try:
            target.mkdir()
        except FileExistsError:
            continue
        except OSError as error:
            raise InputError(f"{target}: cannot be made ({error.strerror}); check the studio's folder") from error
        return target
    raise InputError(f"{root / stem}: there are too many results; move some of them elsewhere")
