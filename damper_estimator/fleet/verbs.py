"""The verbs of a fleet: each runs a use case on one recording and damper and returns the columns of the row."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from damper_estimator.files import json_text, plain, write_text
from damper_estimator.fleet.task import Options, Task, words
from damper_estimator.report import plotly_from
from damper_estimator.signals import DEFAULT_MAX_GAP
from damper_estimator.validation import SPOILING, data_findings
from damper_estimator.workflows import (
    ComparisonResults,
    DiagnosisResults,
    FitOptions,
    Recording,
    ReplayOptions,
    compare,
    diagnose,
    fit_record,
    fit_with,
    read,
    replay_to,
    save_fit,
    signal_map_of,
)

PLOTLY = "plotly.min.js"


@dataclass(frozen=True)
class Compare(Options):
    """Compares the model with the measured force."""

    verb: ClassVar[str] = "compare"

    def run(self, task: Task) -> Mapping[str, object]:
        """As ``Options.run``."""
        results = compare(_recording(task), task.model)
        record = _written(task, results.to_dict())
        quality = record["data_quality"]
        return {**quality, **record} | _data_columns(quality["findings"]) | _page(task, results)


@dataclass(frozen=True)
class Diagnose(Options):
    """Finds missing effects; ``mode`` as in ``workflows.diagnose``."""

    verb: ClassVar[str] = "diagnose"
    mode: str = "both"

    @property
    def words(self) -> tuple[str, ...]:
        """As ``Options.words``."""
        flags = {"kept": ("--keep-parameters",), "refit": ("--refit",)}
        return super().words + flags.get(self.mode, ())

    def run(self, task: Task) -> Mapping[str, object]:
        """As ``Options.run``."""
        results = diagnose(_recording(task), task.model, mode=self.mode)
        record = _written(task, results.to_dict())
        findings = record["findings"]
        columns = {
            "missing": [finding["phenomenon"] for finding in findings],
            "confidence": [finding["confidence"] for finding in findings],
            "rmse_after_n": findings[-1]["rmse_after_n"] if findings else None,
        }
        return {**record, **columns} | _data_columns(record["data_findings"]) | _page(task, results)


@dataclass(frozen=True)
class Fit(Options):
    """Identifies the model's parameters; ``how`` has the options."""

    verb: ClassVar[str] = "fit"
    how: FitOptions = field(default_factory=FitOptions)

    @property
    def words(self) -> tuple[str, ...]:
        """As ``Options.words``."""
        how = self.how
        return super().words + words(
            ("method", how.method),
            *(("free", name) for name in how.free),
            *(("fix", name) for name in how.fix),
            *(("limit", f"{name}={low}:{high}") for name, (low, high) in (how.limits or {}).items()),
            ("seed", how.seed),
            ("population", how.population),
            ("generations", how.generations),
            ("pick", how.pick if how.pick != FitOptions.pick else None),
        )

    def run(self, task: Task) -> Mapping[str, object]:
        """As ``Options.run``."""
        recording = _recording(task)
        results = fit_with(recording, task.model, self.how, _no_progress)
        faults = data_findings(None, recording.measurements[task.damper])
        target = task.place("yaml")
        save_fit(results.fit, target)
        dampers = {task.damper: fit_record(results.fit, target)}
        record = _written(task, {**results.request, "dampers": dampers})
        columns = {
            "parameters": {parameter["name"]: parameter["value"] for parameter in record["parameters"]},
            "standard_errors": {parameter["name"]: parameter["standard_error"] for parameter in record["parameters"]},
        }
        return {**record, **columns} | _data_columns([fault.record() for fault in faults]) | _report(task, target)


@dataclass(frozen=True)
class Replay(Options):
    """Estimates forces as the node does; ``max_gap`` in s."""

    verb: ClassVar[str] = "replay"
    max_gap: float | None = None

    @property
    def words(self) -> tuple[str, ...]:
        """As ``Options.words``."""
        return super().words + words(("max-gap", self.max_gap))

    def run(self, task: Task) -> Mapping[str, object]:
        """As ``Options.run``."""
        output = task.place("mcap")
        max_gap = DEFAULT_MAX_GAP if self.max_gap is None else self.max_gap
        options = ReplayOptions((task.damper,), self.start, self.stop, max_gap)
        signal_map = signal_map_of(task.signals or None)
        counts_of = replay_to(Path(task.recording), task.model, output, signal_map, options, _no_progress)
        dampers = {name: counts.record() for name, counts in counts_of.items()}
        return _written(task, {"output": output, "dampers": dampers}) | _report(task, output)


def work(task: Task) -> Mapping[str, object]:
    """Executes a task, as ``Options.run``."""
    return task.options.run(task)


def _recording(task: Task) -> Recording:
    options = task.options
    return read(
        task.recording, signals=task.signals or None, dampers=task.damper, start=options.start, stop=options.stop
    )


def _written(task: Task, record: Mapping[str, object]) -> dict:
    """Writes the results as the verb does with ``--json``; returns those of the damper."""
    write_text(task.place("json"), json_text(record))
    return plain(record)["dampers"][task.damper]


def _data_columns(findings: Sequence[Mapping[str, object]]) -> dict[str, object]:
    """The columns with the faults of the recording; ``spoiled`` has those that leave the results without a meaning."""
    text = {f"{one['kind']}: {one['sentence']}; {one['remedy']}": one["kind"] in SPOILING for one in findings}
    return {"data_findings": list(text), "spoiled": ". ".join(line for line, spoils in text.items() if spoils)}


def _page(task: Task, results: ComparisonResults | DiagnosisResults) -> dict[str, object]:
    if not task.pages:
        return _report(task, task.place("json"))
    target = task.place("html")
    with plotly_from(f"../../{PLOTLY}"):  # one copy serves all pages
        results.save(target)
    return _report(task, target)


def _report(task: Task, path: Path) -> dict[str, object]:
    """The column with the path of the report; without pages that of the JSON file."""
    return {"report": "/".join((path if task.pages else task.place("json")).parts[-3:])}


def _no_progress(text: str) -> None:
    """Discards progress lines: the results contain the same."""
