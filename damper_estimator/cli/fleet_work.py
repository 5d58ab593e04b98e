"""What a worker of the fleet does: the verb itself, on one recording and damper, as a user would call it."""

import argparse
import io
import json
from collections.abc import Callable, Mapping
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from importlib import import_module

from damper_estimator.fleet.task import Task
from damper_estimator.report.page import plotly_from

PLOTLY = "plotly.min.js"
_ENDINGS = {"compare": "html", "diagnose": "html", "fit": "yaml", "replay": "mcap"}


def work(task: Task) -> dict[str, object]:
    """Runs the verb; its JSON, and its page, model or recording, lie beside each other.

    Returns:
        values of the row's columns.

    Raises:
        InputError: where the verb refuses the recording.
    """
    module = import_module(f"damper_estimator.cli.{task.verb}")
    parser = argparse.ArgumentParser(allow_abbrev=False)
    module.add_arguments(parser)
    words = [task.recording, f"--model={task.model}", f"--damper={task.damper}", f"--json={task.place('json')}"]
    words += [f"--signals={task.signals}"] if task.signals else []
    with ExitStack() as stack:
        # What the verb says is in its JSON; plotly lies once beside all pages.
        stack.enter_context(redirect_stdout(io.StringIO()))
        stack.enter_context(redirect_stderr(io.StringIO()))
        stack.enter_context(plotly_from(f"../../{PLOTLY}"))
        module.run(parser.parse_args([*words, *_results(task), *task.words]))
    record = json.loads(task.place("json").read_text(encoding="utf-8"))["dampers"][task.damper]
    report = task.place(_ENDINGS[task.verb] if task.pages else "json")
    return _COLUMNS[task.verb](record) | {"report": "/".join(report.parts[-3:])}


def _results(task: Task) -> list[str]:
    path = task.place(_ENDINGS[task.verb])
    if task.verb in ("fit", "replay"):
        return [f"--output={path}"]
    own = ["--workers=1"] if task.verb == "diagnose" else []
    return own + ([f"--html={path}"] if task.pages else [])


def _compared(record: Mapping) -> dict[str, object]:
    return {**record["data_quality"], **record}


def _diagnosed(record: Mapping) -> dict[str, object]:
    found = record["findings"]
    return {
        **record,
        "missing": [own["phenomenon"] for own in found],
        "confidence": [own["confidence"] for own in found],
        "rmse_after_n": found[-1]["rmse_after_n"] if found else None,
    }


def _fitted(record: Mapping) -> dict[str, object]:
    return {
        **record,
        "parameters": {own["name"]: own["value"] for own in record["parameters"]},
        "standard_errors": {own["name"]: own["standard_error"] for own in record["parameters"]},
    }


_COLUMNS: dict[str, Callable[[Mapping], dict[str, object]]] = {
    "compare": _compared,
    "diagnose": _diagnosed,
    "fit": _fitted,
    "replay": dict,
}
