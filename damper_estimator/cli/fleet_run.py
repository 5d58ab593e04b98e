"""One run of the fleet: workers, progress, and the table and page that are written however it ends."""

import argparse
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import monotonic

from damper_estimator.cli.fit_report import table
from damper_estimator.cli.progress_line import ProgressLine
from damper_estimator.cli.verb_support import progress
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.fleet.cluster import connected, dashboard_of, threads_of
from damper_estimator.fleet.joint_models import JointFits, JointModel
from damper_estimator.fleet.manifest import find_recordings
from damper_estimator.fleet.result_rows import failures_of, read_rows, spoiled_of, write_rows
from damper_estimator.fleet.scheduling import Fleet, FleetRequest, TaskCounts
from damper_estimator.fleet.task import Options
from damper_estimator.fleet.trend import RULE, drifting
from damper_estimator.fleet.verbs import PLOTLY, Compare, work
from damper_estimator.model import load_model
from damper_estimator.report import save_plotly
from damper_estimator.report.fleet_page import fleet_page

_EVERY = 10.0  # s between two lines of progress that cannot be overwritten


@dataclass(frozen=True)
class Done:
    """The outcome of a run.

    Attributes:
        verb: its name.
        rows: file of the dataset.
        page: the fleet's page.
        seconds: duration.
        counts: of the tasks.
        failures: recording, damper and reason of failed tasks, sorted.
        spoiled: recording, damper and fault where results mean nothing before the recording is corrected.
        fits: each joint fit as text.
    """

    verb: str
    rows: Path
    page: Path
    seconds: float
    counts: TaskCounts
    failures: list[dict[str, str]]
    spoiled: list[dict[str, str]]
    fits: tuple[str, ...] = ()

    @property
    def summary(self) -> str:
        """The outcome in one line."""
        t = self.counts
        rate = f" ({t.done / self.seconds:.3g} a second)" if t.done and self.seconds > 0.0 else ""
        return (
            f"{t.known} tasks of {t.recordings} recordings: {t.kept} done before, {t.done} done now{rate}; "
            f"{t.failed} failed"
        )

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {
            "verb": self.verb,
            "rows": self.rows,
            "page": self.page,
            "recordings": self.counts.recordings,
            "tasks": self.counts.known,
            "kept": self.counts.kept,
            "done": self.counts.done,
            "failed": self.counts.failed,
            "seconds": self.seconds,
            "failures": self.failures,
            "spoiled": self.spoiled,
        }


def write_fleet_page(output: Path) -> Path:
    """Writes the fleet's page from the rows of all verbs in the folder."""
    rows = read_rows(output)
    trends, judged = drifting([row for row in rows.get("compare", ()) if not row["spoiled"]])
    page = output / "index.html"
    write_text(page, fleet_page(rows, [asdict(trend) for trend in trends], judged, RULE))
    return page


class FleetProgress:
    """Shows counts on a progress line with rate and remaining time; without a terminal every ten seconds."""

    def __init__(self, line: ProgressLine) -> None:
        self.line, self.begun = line, monotonic()
        self.shown = self.begun

    def __call__(self, counts: TaskCounts) -> None:
        now = monotonic()
        if not self.line.overwrites and now - self.shown < _EVERY:
            return
        self.shown = now
        rate = counts.done / max(now - self.begun, 1e-9)
        left = counts.expected - counts.kept - counts.done
        share = (counts.kept + counts.done) / max(counts.expected, 1.0)
        text = f"{counts.kept + counts.done} of {counts.expected:.0f} tasks"
        text += f", {rate:.3g} a second, {_duration(left / rate)} left" if counts.done else ""
        text += f", {counts.failed} failed" if counts.failed else ""
        self.line(text, min(share, 1.0))


def _duration(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    if seconds < 6000.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"


def run_fleet(arguments: argparse.Namespace, options: Options) -> Done:
    """Executes missing tasks; table and page are written at the end, also after an interruption.

    Raises:
        InputError: if the run cannot start, or results cannot be written.
    """
    began = monotonic()
    recordings = find_recordings(arguments.sources, arguments.dampers, arguments.signals)
    output = _folder(arguments.output, pages=not arguments.no_pages)
    request = FleetRequest(options, _absolute_model(arguments.model), output, not arguments.no_pages, arguments.retry)
    fits: tuple[str, ...] = ()
    with connected(arguments.scheduler, arguments.workers, arguments.memory) as client:
        _report_cluster(dashboard_of(client), threads_of(client))
        if getattr(arguments, "joint", None):
            with ProgressLine("fleet overview") as line:
                found = Fleet(request, recordings, None, FleetProgress(line))
                found.run(client)
            joint = JointFits(options, arguments.output, arguments.joint == "vehicle", arguments.sources[0], progress)
            fits = tuple(_fit_text(model) for model in joint.models(client, found.tasks))
            # Then every recording is compared with its model.
            request = replace(request, options=Compare(options.start, options.stop))
            recordings = joint.with_models(recordings)
        verb = request.options.verb
        with ProgressLine(f"fleet {verb}") as line:
            fleet = Fleet(request, recordings, work, FleetProgress(line))
            try:
                fleet.run(client)
            finally:
                rows = write_rows(output, verb, fleet.tasks)
                page = write_fleet_page(output)
    return Done(verb, rows, page, monotonic() - began, fleet.counts, failures_of(rows), spoiled_of(rows), fits)


def _fit_text(model: JointModel) -> str:
    if model.fit is None:
        return f"{model.name}: nothing changed; {model.target} is kept"
    return "\n".join(
        [table(model.name, model.fit, model.target), *(f"  left out: {reason}" for _, reason in model.left_out)]
    )


def _folder(output: Path, pages: bool) -> Path:
    output = output.absolute()
    try:
        output.mkdir(parents=True, exist_ok=True)
        if pages:
            save_plotly(output / PLOTLY)
    except OSError as error:
        raise InputError(f"{output}: cannot be created ({error.strerror}); choose another place with -o") from error
    return output


def _absolute_model(named: str) -> str:
    """The model as workers in any folder find it; checked before the run starts."""
    path = Path(named).absolute()
    if not path.is_dir():
        load_model(named)
    return str(path) if path.exists() else named


def _report_cluster(dashboard: str, threads: int) -> None:
    where = f"; dashboard {dashboard}" if dashboard else ""
    if threads:
        progress(f"{threads} worker{'s' if threads > 1 else ''}{where}")
    else:
        progress(f"the scheduler has no worker; waiting for one{where}")
