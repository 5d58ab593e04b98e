"""The whole work: looks into recordings, tasks for what is missing or changed, no more under way than are needed.

A task is submitted when another one is done, so that neither client nor scheduler hold thousands; what travels is the
task and what became of it. Each row lies on the disk before its task counts as done: whoever is killed, at any time,
the next run goes on from there.

Dask blames a dead worker on everything that lay on it, also on what only waited there. What it gives up so is tried
once more when all else is done, by itself: only what then takes its workers down has failed.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic

from distributed import Client, Future, KilledWorker, as_completed

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.fleet.carry import Outcome, Work, carry_out
from damper_estimator.fleet.cluster import answering, threads_of
from damper_estimator.fleet.look import Look, kept_look, map_checksum, state_of, take_look
from damper_estimator.fleet.manifest import Recording
from damper_estimator.fleet.rows import FAILED, kept_row, write_row
from damper_estimator.fleet.task import Options, Task, digest, task_folder
from damper_estimator.model import load_model
from damper_estimator.model.model_files import model_yaml

_AHEAD = 4  # tasks under way per thread: one runs, the others wait beside it
_COUNTED = 5.0  # s between two counts of the workers
_KILLED = "took its worker down again and again; it may need more memory (--memory), or show a fault: run it alone"


@dataclass(frozen=True)
class Asked:
    """What is asked of every recording.

    Attributes:
        options, pages: as in ``Task``.
        model: name, file or folder.
        output: folder of the results.
        retry: whether what failed before is tried again although nothing changed.
    """

    options: Options
    model: str
    output: Path
    pages: bool = True
    retry: bool = False


@dataclass
class Tally:
    """How far the work is; tasks that the looks have still to find are not in ``known``.

    Attributes:
        recordings, looked: recordings in all, and those whose dampers are known.
        known: tasks; ``kept`` of them were done before, ``done`` are done now, ``failed`` of both failed.
        seconds: of work, over all workers.
    """

    recordings: int = 0
    looked: int = 0
    known: int = 0
    kept: int = 0
    done: int = 0
    failed: int = 0
    seconds: float = 0.0

    @property
    def expected(self) -> float:
        """Tasks that there will be; recordings not looked into count as many as the others have on average."""
        return self.known * self.recordings / self.looked if self.looked else float(self.recordings)


@dataclass
class Fleet:
    """The work on all recordings; final.

    Attributes:
        tasks: all that are known so far.
        tally: how far they are.
    """

    asked: Asked
    recordings: Sequence[Recording]
    work: Work | None  # None only looks into the recordings
    tell: Callable[[Tally], None]
    tasks: list[Task] = field(default_factory=list)
    tally: Tally = field(default_factory=Tally)
    _models: dict[tuple[str, str], str] = field(default_factory=dict)
    _suspects: deque[Recording | Task] = field(default_factory=deque)
    _alone: Recording | Task | None = None  # the suspect that is tried by itself

    def run(self, client: Client) -> None:
        """Does what is not done.

        Raises:
            InputError: where results cannot be written or the scheduler is gone; what was done is kept.
        """
        self.tally.recordings = len(self.recordings)
        waiting: deque[Recording | Task] = deque(self.recordings)
        under_way: dict[Future, Recording | Task] = {}
        finished = as_completed([], raise_errors=False)
        room, counted = 0, -_COUNTED
        with answering():
            while waiting or under_way or self._suspects:
                if not waiting and not under_way:
                    self._alone = self._suspects.popleft()
                    waiting.append(self._alone)
                if monotonic() - counted >= _COUNTED:
                    room, counted = _AHEAD * max(threads_of(client), 1), monotonic()
                while waiting and len(under_way) < room:
                    self._begin(client, waiting, under_way, finished)
                if under_way:
                    future = next(finished)
                    self._end(future, under_way.pop(future), waiting)
                self.tell(self.tally)

    def _begin(self, client: Client, waiting: deque, under_way: dict, finished: as_completed) -> None:
        """Submits the next thing to do, unless it is done already."""
        own = waiting.popleft()
        if isinstance(own, Recording):
            folder = task_folder(self.asked.output, own.path)
            look = kept_look(folder, state_of(own.path, own.signals))
            if look is not None:
                self._found(own, look, waiting)
                return
            future = client.submit(take_look, own.path, own.signals, str(folder), pure=False)
        else:
            future = client.submit(carry_out, own, self.work, __version__, pure=False)
        under_way[future] = own
        finished.add(future)

    def _end(self, future: Future, own: Recording | Task, waiting: deque) -> None:
        """Takes in what became of something submitted."""
        try:
            told: Look | Outcome = future.result()
        except KilledWorker:
            if own is not self._alone:
                self._suspects.append(own)
                return
            told = Outcome(f"{own.recording}: {_KILLED}", 0.0) if isinstance(own, Task) else self._unlooked(own)
            if isinstance(own, Task):
                write_row(own, FAILED, told.reason, {})
        if isinstance(own, Recording):
            self._found(own, told, waiting)
            return
        self.tally.done += 1
        self.tally.failed += told.reason != ""
        self.tally.seconds += told.seconds

    def _unlooked(self, own: Recording) -> Look:
        state = state_of(own.path, own.signals)
        return Look(state, state, None, None, {}, f"{own.path}: {_KILLED}")

    def _found(self, own: Recording, look: Look, waiting: deque) -> None:
        """Tasks of a recording whose dampers are known; those not done yet come next."""
        self.tally.looked += 1
        for damper in own.dampers or tuple(look.temperature_c) or ("",):
            task, reason = self._task(own, look, damper)
            self.tasks.append(task)
            self.tally.known += 1
            if self.work is None:
                continue
            row = kept_row(task)
            if row is not None and not (self.asked.retry and row["status"] == FAILED):
                self.tally.kept += 1
                self.tally.failed += row["status"] == FAILED
            elif reason:
                write_row(task, FAILED, reason, {})
                self.tally.done += 1
                self.tally.failed += 1
            else:
                waiting.appendleft(task)

    def _task(self, own: Recording, look: Look, damper: str) -> tuple[Task, str]:
        """The task of one damper, and why it need not be tried, "" where it is to be."""
        model, reason = own.model or self.asked.model, look.reason
        model_checksum = ""
        try:
            model_checksum = self._model_checksum(model, damper) if damper else ""
        except InputError as error:
            reason = reason or str(error)
        facts = {
            "vehicle": own.vehicle,
            "begin": look.begin_ns,
            "seconds": look.seconds,
            "notes": look.notes,
            "temperature_c": look.temperature_c.get(damper),
            "recording_checksum": look.checksum,
            "model_checksum": model_checksum,
            "signals_checksum": map_checksum(own.signals),
            "version": __version__,
        }
        folder, asked = str(task_folder(self.asked.output, own.path)), self.asked
        task = Task(asked.options, own.path, damper, own.signals, model, folder, asked.pages, facts)
        return task, reason

    def _model_checksum(self, model: str, damper: str) -> str:
        if (model, damper) not in self._models:
            self._models[model, damper] = digest(model_yaml(load_model(model, damper)))
        return self._models[model, damper]
