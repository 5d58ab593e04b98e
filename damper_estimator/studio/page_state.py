"""The state of one page and what leads to it: the versions of the model, forces on view, a job; no verbs."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

from damper_estimator.diagnosis import Diagnosis
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.studio.corners import Corner
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.history import History, Version
from damper_estimator.studio.job import Job
from damper_estimator.studio.long_tasks import Case, Change, judged
from damper_estimator.studio.model_run import ModelRun, run_model
from damper_estimator.studio.rig_tasks import RigTest
from damper_estimator.studio.session_files import SessionFiles, Stamp
from damper_estimator.studio.session_writer import SessionWriter
from damper_estimator.studio.stage import Choice, Stage, Stretch
from damper_estimator.studio.worker_process import Progress
from damper_estimator.validation import Comparison

_KEPT = 6  # models whose forces are kept


@dataclass(frozen=True)
class OtherDamper:
    """A damper that was left for another one of the same recordings.

    Attributes:
        saved: versions that are in a model file, and the file's name.
        file: name and stamp of the session's file.
        left_out: stretches that nothing is fitted to or judged on.
    """

    history: History
    saved: tuple[tuple[Version, str], ...] = ()
    file: tuple[str, Stamp] = ("", None)
    left_out: tuple[Stretch, ...] = ()


class PageState:
    """The state of one page; ``Session`` adds the verbs.

    Attributes:
        names: of the models that were opened, as they were chosen.
        writer: writes the steps to the session's file.
        stage, history, others: None, None and () until something is open; ``others`` are further models on view.
        diagnosis: of which version of the model, and what was found; None until one was made.
        diagnosed: the marked region that it is of; "" for all that is open.
        job, jobs: the long work that goes on, or the last one, and how many there were.
        corners: the overview of all dampers, by name; empty before they were compared.
        other_dampers: steps of the other dampers of the same recordings.
        tests: diagrams and plans that were made, in order.
        opened: counts what was opened.
        centres: value of every parameter by address when the list of parameters last changed: its slider's middle.
        generation: counts changes of what is on view.
        rebuilt: counts changes after which the list of parameters is another one.
    """

    def __init__(self, folder: Folder, owner: str = "") -> None:
        """``owner`` is the browser tab, which goes on in the file that it wrote itself."""
        self.folder, self.owner = folder, owner
        self.names: tuple[str, ...] = ()
        self.writer = SessionWriter(SessionFiles(folder), owner)
        self.stage: Stage | None = None
        self.history: History | None = None
        self.others: tuple[DamperModel, ...] = ()
        self.diagnosis: Diagnosis | None = None
        self.diagnosed = ""
        self.job: Job | None = None
        self.corners: dict[str, Corner] = {}
        self.other_dampers: dict[str, OtherDamper] = {}
        self.centres: dict[str, float] = {}
        self.opened = self.generation = self.rebuilt = 0
        self._lock, self._judging = threading.RLock(), threading.Lock()
        self.tests: tuple[RigTest, ...] = ()
        self._shown: list[ModelRun] = []
        self._compared: list[tuple[ModelRun, Comparison]] = []
        self._saved: list[tuple[Version, str]] = []

    @property
    def model(self) -> DamperModel:
        """The model that is worked on.

        Raises:
            InputError: while nothing is open.
        """
        return self._now().step.model

    @property
    def here(self) -> Stage:
        """What is open, with the corrections of the version on view.

        Raises:
            InputError: while nothing is open.
        """
        now = self._now()
        return self.stage.corrected(now.signals)

    def models(self) -> list[DamperModel]:
        """The models on view: the one that is worked on, the same as given where it was changed, the others."""
        given = [self.history.versions[0].step.model] if self.history and self.history.at else []
        return [self.model, *given, *self.others]

    def shown(self, model: DamperModel) -> ModelRun:
        """A model's forces over what is open; kept for the last few."""
        with self._lock:
            stage = self.here if model is self.model else self.stage
            for run in self._shown:
                if run.model is model and run.stage.signals == stage.signals:
                    return run
            run = run_model(model, stage)
            self._shown = [*self._shown[1 - _KEPT :], run]
            return run

    def comparison(self, shown: ModelRun) -> Comparison:
        """Where a model fails; kept for the last few. Long recordings take seconds, in which the page is looked at."""
        with self._judging:
            for run, comparison in self._compared:
                if run is shown:
                    return comparison
            comparison = shown.comparison()
            self._compared = [*self._compared[1 - _KEPT :], (shown, comparison)]
            return comparison

    def histories(self) -> dict[str, History]:
        """The steps of every damper of the recordings that was looked at, by its name."""
        here = {self.stage.damper: self.history} if self.stage and self.history else {}
        return {name: other.history for name, other in self.other_dampers.items()} | here

    def choice_of(self, damper: str) -> Choice:
        """What is open, for another damper: with what was left out of its own recordings."""
        other = self.other_dampers.get(damper)
        left_out = self.stage.choice.left_out if damper == self.stage.damper else other.left_out if other else ()
        return replace(self.stage.choice, damper=damper, left_out=left_out)

    @property
    def unsaved(self) -> bool:
        """Whether the model on view is the result of steps and in no model file."""
        return self.history is not None and self.history.at > 0 and not self.saved_as(self.history.now)

    @property
    def busy(self) -> bool:
        """Whether long work goes on."""
        return self.job is not None and self.job.running

    def saved(self, name: str) -> None:
        """The model on view was written to a file of the folder."""
        with self._lock:
            self._saved = [*((version, file) for version, file in self._saved if file != name), (self._now(), name)]
            self._changed(rebuilt=False)

    def saved_as(self, version: Version) -> str:
        """The file that a version's model was written to last; "" where there is none."""
        return next((file for saved, file in reversed(self._saved) if saved is version), "")

    def rest(self) -> None:
        """Ends the work that goes on."""
        if self.job is not None:
            self.job.cancel()

    def close(self) -> None:
        """Ends the work that goes on and lets go of all that was read."""
        self.rest()
        self.stage, self.history, self.diagnosis = None, None, None
        self._shown, self._compared, self._saved = [], [], []
        self.corners, self.other_dampers = {}, {}

    def start(self, name: str, work: Callable[[Progress], None]) -> None:
        """Begins a long work.

        Raises:
            InputError: while another one goes on.
        """
        with self._lock:
            if self.busy:
                raise InputError(f"{self.job.name} goes on; cancel it first, or wait")
            self.job = Job(name, work, self.job.number + 1 if self.job else 1)

    def keep_test(self, test: RigTest) -> None:
        """Adds a result to the list of tests."""
        with self._lock:
            self.tests = (*self.tests, test)
            self._changed(rebuilt=False, kept=False)

    def _case(self) -> Case:
        return self.here.case(self.model)

    def _then_judged(self, model: DamperModel, change: Change, rebuilt: bool = True) -> None:
        stage = self.here
        self._then(Version(judged(stage.case(model), change), self._now().signals), rebuilt)

    def _then(self, version: Version, rebuilt: bool = True) -> None:
        with self._lock:
            self.history = self.history.then(version)
            self._changed(rebuilt)

    def _restaged(self, stage: Stage) -> None:
        """Takes other samples for judging; every step is judged again on them."""
        history, before = self.history, self.history.versions
        versions = [_judged_again(version, stage) for version in before]
        places = {id(version): i for i, version in enumerate(before)}
        with self._lock:
            self.stage, self.history = stage, replace(history, versions=tuple(versions))
            self._saved = [
                (versions[places[id(version)]], file) for version, file in self._saved if id(version) in places
            ]
            self._shown, self._compared = [], []
            self._changed()

    def _now(self) -> Version:
        if self.history is None:
            raise InputError("nothing is open yet: choose a recording and a model, then open them")
        return self.history.now

    def _changed(self, rebuilt: bool = True, kept: bool = True) -> None:
        self.generation += 1
        if kept:
            self.writer.write(self.stage, self.names, self.history, self._saved)
        if rebuilt:
            self.rebuilt += 1
            self.centres = {slot.address: slot.value for slot in self.model.slots}


def _judged_again(version: Version, stage: Stage) -> Version:
    step = version.step
    step_now = judged(stage.corrected(version.signals).case(step.model), Change(step.action))
    return replace(version, step=replace(step, rmse_fit_n=step_now.rmse_fit_n, rmse_unseen_n=step_now.rmse_unseen_n))
