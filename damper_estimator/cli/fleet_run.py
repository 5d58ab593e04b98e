"""One run of the fleet: workers, progress, and the table and the page at its end, however it ends."""

import argparse
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import monotonic

from damper_estimator.cli.common import progress
from damper_estimator.cli.fit_report import table
from damper_estimator.cli.work_line import WorkLine
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.fleet.cluster import connected, dashboard_of, threads_of
from damper_estimator.fleet.joint_models import JointFits, JointModel
from damper_estimator.fleet.manifest import find_recordings
from damper_estimator.fleet.rows import failures_of, read_rows, write_rows
from damper_estimator.fleet.run import Asked, Fleet, Tally
from damper_estimator.fleet.task import Options
from damper_estimator.fleet.trend import RULE, drifting
from damper_estimator.fleet.verbs import PLOTLY, Compare, work
from damper_estimator.model import load_model
from damper_estimator.report import save_plotly
from damper_estimator.report.fleet_page import fleet_page

_EVERY = 10.0  # s between two lines of progress where they cannot be written over


@dataclass(frozen=True)
class Done:
    """What came of a run.

    Attributes:
        verb: what was done.
        rows: of the dataset.
        page: the fleet's.
        seconds: that it took.
        tally: how many tasks.
        failures: recording, damper and reason of those that failed, sorted.
        fits: what is told of each joint fit.
    """

    verb: str
    rows: Path
    page: Path
    seconds: float
    tally: Tally
    failures: list[dict[str, str]]
    fits: tuple[str, ...] = ()

    @property
    def summary(self) -> str:
        """One line for people."""
        t = self.tally
        rate = f" ({t.done / self.seconds:.3g} a second)" if t.done and self.seconds > 0.0 else ""
        return (
            f"{t.known} tasks of {t.recordings} recordings: {t.kept} were done before, {t.done} done now{rate}; "
            f"{t.failed} failed"
        )

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {
            "verb": self.verb,
            "rows": self.rows,
            "page": self.page,
            "recordings": self.tally.recordings,
            "tasks": self.tally.known,
            "kept": self.tally.kept,
            "done": self.tally.done,
            "failed": self.tally.failed,
            "seconds": self.seconds,
            "failures": self.failures,
        }


def write_page(output: Path) -> Path:
    """The fleet's page, of the rows of all verbs that the folder holds."""
    rows = read_rows(output)
    trends, judged = drifting(rows.get("compare", ()))
    page = output / "index.html"
    write_text(page, fleet_page(rows, [asdict(own) for own in trends], judged, RULE))
    return page


class FleetProgress:
    """Tells tallies on a work line, with rate and time left; elsewhere than on a terminal every ten seconds."""

    def __init__(self, line: WorkLine) -> None:
        self.line, self.begun = line, monotonic()
        self.told = self.begun

    def __call__(self, tally: Tally) -> None:
        now = monotonic()
        if not self.line.over and now - self.told < _EVERY:
            return
        self.told = now
        rate = tally.done / max(now - self.begun, 1e-9)
        left = tally.expected - tally.kept - tally.done
        share = (tally.kept + tally.done) / max(tally.expected, 1.0)
        text = f"{tally.kept + tally.done} of {tally.expected:.0f} tasks"
        text += f", {rate:.3g} a second, {_duration(left / rate)} left" if tally.done else ""
        text += f", {tally.failed} failed" if tally.failed else ""
        self.line(text, min(share, 1.0))


def _duration(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    if seconds < 6000.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"


def run_fleet(arguments: argparse.Namespace, options: Options) -> Done:
    """Does what is missing; table and page are made at the end, also where the work was interrupted.

    Raises:
        InputError: where nothing can be begun, or results cannot be written.
    """
    began = monotonic()
    recordings = find_recordings(arguments.sources, arguments.dampers, arguments.signals)
    output = _folder(arguments.output, pages=not arguments.no_pages)
    asked = Asked(options, _model(arguments.model), output, not arguments.no_pages, arguments.retry)
    fits: tuple[str, ...] = ()
    with connected(arguments.scheduler, arguments.workers, arguments.memory) as client:
        _tell_cluster(dashboard_of(client), threads_of(client))
        if getattr(arguments, "joint", None):
            with WorkLine("fleet looks") as line:
                found = Fleet(asked, recordings, None, FleetProgress(line))
                found.run(client)
            joint = JointFits(options, arguments.output, arguments.joint == "vehicle", arguments.sources[0], progress)
            fits = tuple(_in_words(own) for own in joint.models(client, found.tasks))
            # What is left is to hold every recording against the model that was found for it.
            asked = replace(asked, options=Compare(options.start, options.stop))
            recordings = joint.with_models(recordings)
        verb = asked.options.verb
        with WorkLine(f"fleet {verb}") as line:
            fleet = Fleet(asked, recordings, work, FleetProgress(line))
            try:
                fleet.run(client)
            finally:
                rows = write_rows(output, verb, fleet.tasks)
                page = write_page(output)
    return Done(verb, rows, page, monotonic() - began, fleet.tally, failures_of(rows), fits)


def _in_words(own: JointModel) -> str:
    if own.fit is None:
        return f"{own.name}: nothing changed; {own.target} stays"
    return "\n".join([table(own.name, own.fit, own.target), *(f"  left out: {reason}" for _, reason in own.left_out)])


def _folder(output: Path, pages: bool) -> Path:
    output = output.absolute()
    try:
        output.mkdir(parents=True, exist_ok=True)
        if pages:
            save_plotly(output / PLOTLY)
    except OSError as error:
        raise InputError(f"{output}: cannot be made ({error.strerror}); choose another place with -o") from error
    return output


def _model(named: str) -> str:
    """The model as workers in any folder find it; refused before the work where it is none."""
    path = Path(named).absolute()
    if not path.is_dir():
        load_model(named)
    return str(path) if path.exists() else named


def _tell_cluster(dashboard: str, threads: int) -> None:
    where = f"; dashboard {dashboard}" if dashboard else ""
    if threads:
        progress(f"{threads} worker{'s' if threads > 1 else ''}{where}")
    else:
        progress(f"the scheduler has no worker yet; waiting for one{where}")
