"""Schedules a run: overviews of recordings, then tasks for results that are missing or outdated.

A task is submitted when another one finishes, so that client and scheduler never queue thousands; only the task and
its outcome are sent. Each row is on the disk before its task counts as done: after a crash of any process at any time
the next run continues from there.

Dask blames the death of a worker on every task assigned to it, even on those that only waited. Tasks that it gives up
for this reason are retried one at a time when all others are done: only a task that then kills its workers has failed.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic

from distributed import Client, Future, KilledWorker, as_completed

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.fleet.cluster import answering, threads_of
from damper_estimator.fleet.manifest import Recording
from damper_estimator.fleet.recording_overview import (
    RecordingOverview,
    kept_overview,
    map_checksum,
    read_overview,
    state_of,
)
from damper_estimator.fleet.result_rows import FAILED, stored_row, write_row
from damper_estimator.fleet.task import Options, Task, digest, task_folder
from damper_estimator.fleet.task_execution import Outcome, Work, execute
from damper_estimator.model import load_model
from damper_estimator.model.model_files import model_yaml

_AHEAD = 4  # submitted tasks per thread: one runs, the others wait
_COUNT_PERIOD = 5.0  # s between two counts of the workers
_KILLED = "killed its worker repeatedly; it may need more memory (--memory), or reveal a fault: run it alone"


@dataclass(frozen=True)
class FleetRequest:
    """The request for a run.

    Attributes:
        options, pages: as in ``Task``.
        model: name, file or folder.
        output: folder of the results.
        retry: whether failed tasks are tried again although nothing changed.
    """

    options: Options
    model: str
    output: Path
    pages: bool = True
    retry: bool = False


@dataclass
class TaskCounts:
    """Progress of a run; ``known`` excludes tasks of recordings without an overview so far.

    Attributes:
        recordings, looked_at: all recordings, and those whose dampers are known.
        known: tasks; ``kept`` of them were done before this run, ``done`` in this run; ``failed`` of both failed.
        seconds: duration of the work, summed over all workers.
    """

    recordings: int = 0
    looked_at: int = 0
    known: int = 0
    kept: int = 0
    done: int = 0
    failed: int = 0
    seconds: float = 0.0

    @property
    def expected(self) -> float:
        """Expected number of tasks; recordings without an overview count with the average of the others."""
        return self.known * self.recordings / self.looked_at if self.looked_at else float(self.recordings)


@dataclass
class Fleet:
    """A run over all recordings; final.

    Attributes:
        tasks: those known so far.
        counts: their progress.
    """

    request: FleetRequest
    recordings: Sequence[Recording]
    work: Work | None  # None only reads the overviews
    progress: Callable[[TaskCounts], None]
    tasks: list[Task] = field(default_factory=list)
    counts: TaskCounts = field(default_factory=TaskCounts)
    _models: dict[tuple[str, str], str] = field(default_factory=dict)
    _suspects: deque[Recording | Task] = field(default_factory=deque)
    _alone: Recording | Task | None = None  # the suspect that is tried alone

    def run(self, client: Client) -> None:
        """Executes all tasks without a valid result.

        Raises:
            InputError: if results cannot be written or the scheduler is lost; finished results are kept.
        """
        self.counts.recordings = len(self.recordings)
        waiting: deque[Recording | Task] = deque(self.recordings)
        pending: dict[Future, Recording | Task] = {}
        finished = as_completed([], raise_errors=False)
        capacity, counted = 0, -_COUNT_PERIOD
        with answering():
            while waiting or pending or self._suspects:
                if not waiting and not pending:
                    self._alone = self._suspects.popleft()
                    waiting.append(self._alone)
                if monotonic() - counted >= _COUNT_PERIOD:
                    capacity, counted = _AHEAD * max(threads_of(client), 1), monotonic()
                while waiting and len(pending) < capacity:
                    self._begin(client, waiting, pending, finished)
                if pending:
                    future = next(finished)
                    self._end(future, pending.pop(future), waiting)
                self.progress(self.counts)

    def _begin(self, client: Client, waiting: deque, pending: dict, finished: as_completed) -> None:
        """Submits the next recording or task unless its result exists."""
        item = waiting.popleft()
        if isinstance(item, Recording):
            folder = task_folder(self.request.output, item.path)
            overview = kept_overview(folder, state_of(item.path, item.signals))
            if overview is not None:
                self._found(item, overview, waiting)
                return
            future = client.submit(read_overview, item.path, item.signals, str(folder), pure=False)
        else:
            future = client.submit(execute, item, self.work, __version__, pure=False)
        pending[future] = item
        finished.add(future)

    def _end(self, future: Future, item: Recording | Task, waiting: deque) -> None:
        """Handles the outcome of a submitted recording or task."""
        try:
            outcome: RecordingOverview | Outcome = future.result()
        except KilledWorker:
            if item is not self._alone:
                self._suspects.append(item)
                return
            outcome = (
                Outcome(f"{item.recording}: {_KILLED}", 0.0) if isinstance(item, Task) else self._failed_overview(item)
            )
            if isinstance(item, Task):
                write_row(item, FAILED, outcome.reason, {})
        if isinstance(item, Recording):
            self._found(item, outcome, waiting)
            return
        self.counts.done += 1
        self.counts.failed += outcome.reason != ""
        self.counts.seconds += outcome.seconds

    def _failed_overview(self, recording: Recording) -> RecordingOverview:
        state = state_of(recording.path, recording.signals)
        return RecordingOverview(state, state, None, None, {}, f"{recording.path}: {_KILLED}")

    def _found(self, recording: Recording, overview: RecordingOverview, waiting: deque) -> None:
        """Adds the tasks of a recording whose dampers are known; unfinished ones come next."""
        self.counts.looked_at += 1
        for damper in recording.dampers or tuple(overview.temperature_c) or ("",):
            task, reason = self._task(recording, overview, damper)
            self.tasks.append(task)
            self.counts.known += 1
            if self.work is None:
                continue
            row = stored_row(task)
            if row is not None and not (self.request.retry and row["status"] == FAILED):
                self.counts.kept += 1
                self.counts.failed += row["status"] == FAILED
            elif reason:
                write_row(task, FAILED, reason, {})
                self.counts.done += 1
                self.counts.failed += 1
            else:
                waiting.appendleft(task)

    def _task(self, recording: Recording, overview: RecordingOverview, damper: str) -> tuple[Task, str]:
        """The task of one damper, and the reason to skip it, "" if there is none."""
        model, reason = recording.model or self.request.model, overview.reason
        model_checksum = ""
        try:
            model_checksum = self._model_checksum(model, damper) if damper else ""
        except InputError as error:
            reason = reason or str(error)
        facts = {
            "vehicle": recording.vehicle,
            "begin": overview.begin_ns,
            "seconds": overview.seconds,
            "notes": overview.notes,
            "temperature_c": overview.temperature_c.get(damper),
            "recording_checksum": overview.checksum,
            "model_checksum": model_checksum,
            "signals_checksum": map_checksum(recording.signals),
            "version": __version__,
        }
        folder, request = str(task_folder(self.request.output, recording.path)), self.request
        task = Task(request.options, recording.path, damper, recording.signals, model, folder, request.pages, facts)
        return task, reason

    def _model_checksum(self, model: str, damper: str) -> str:
        if (model, damper) not in self._models:
            self._models[model, damper] = digest(model_yaml(load_model(model, damper)))
        return self._models[model, damper]
