"""The results as one table: a small file per task, collected into a columnar dataset (Parquet).

``rows/VERB.parquet`` has a row per recording and damper, sorted by both; all verbs have the same columns, so
``rows/`` is one dataset. Rows do not depend on the time or place of the run: equal inputs give equal files.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import pyarrow
import pyarrow.parquet

from damper_estimator.files import replacing, write_text
from damper_estimator.fleet.task import Task

ROWS = "rows"
DONE, FAILED = "done", "failed"
_BATCH = 5000  # rows in memory at a time

_TEXT, _NUMBER, _COUNT = pyarrow.string(), pyarrow.float64(), pyarrow.int64()
_NUMBERS = pyarrow.map_(_TEXT, _NUMBER)
COLUMNS = {
    "verb": _TEXT, "recording": _TEXT, "vehicle": _TEXT, "damper": _TEXT,
    "status": _TEXT, "reason": _TEXT, "notes": _TEXT, "report": _TEXT,
    "begin": pyarrow.timestamp("ns", tz="UTC"), "seconds": _NUMBER, "temperature_c": _NUMBER,
    "model": _TEXT, "model_file": _TEXT, "model_checksum": _TEXT, "signals": _TEXT, "signals_checksum": _TEXT,
    "recording_checksum": _TEXT, "settings": _TEXT, "version": _TEXT, "fingerprint": _TEXT,
    "samples": _COUNT, "force_rms_n": _NUMBER, "rmse_n": _NUMBER, "nrmse": _NUMBER, "esr": _NUMBER,
    "fit_percent": _NUMBER, "correlation": _NUMBER, "peak_error_n": _NUMBER, "energy_error": _NUMBER,
    "bias_n": _NUMBER, "noise_floor_n": _NUMBER,
    "rmse_before_n": _NUMBER, "esr_before": _NUMBER, "parameters": _NUMBERS, "standard_errors": _NUMBERS,
    "verdict": _TEXT, "missing": pyarrow.list_(_TEXT), "confidence": pyarrow.list_(_NUMBER),
    "rmse_after_n": _NUMBER,
    "estimates": _COUNT, "residual_rms_n": _NUMBER,
    "data_findings": pyarrow.list_(_TEXT), "spoiled": _TEXT,
    "gaps": _COUNT, "inversions": _COUNT, "duplicates": _COUNT, "non_finite": _COUNT,
}  # fmt: skip
SCHEMA = pyarrow.schema(list(COLUMNS.items()))


def write_row(task: Task, status: str, reason: str, values: Mapping[str, object]) -> None:
    """Stores the row of a task that is done or has finally failed.

    Raises:
        InputError: if it cannot be written.
    """
    row = dict(task.facts) | {
        "verb": task.verb,
        "recording": task.recording,
        "damper": task.damper,
        "status": status,
        "reason": reason,
        "model_file": task.model,
        "signals": task.signals,
        "settings": " ".join(task.options.words),
        "fingerprint": task.fingerprint,
    }
    columns = {name: values[name] for name in COLUMNS if name in values}
    Path(task.folder).mkdir(parents=True, exist_ok=True)
    write_text(task.place("row.json"), json.dumps(columns | row, allow_nan=False))


def stored_row(task: Task) -> dict[str, object] | None:
    """The stored row of a task; None if there is none or the task has changed."""
    row = _read(task.place("row.json"))
    return row if row is not None and row["fingerprint"] == task.fingerprint else None


def _read(path: Path) -> dict[str, object] | None:
    try:
        row = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return row if isinstance(row, dict) and "fingerprint" in row else None


def write_rows(output: Path, verb: str, tasks: Iterable[Task]) -> Path:
    """Writes the dataset of a verb from the stored rows of its tasks; replaces an older one in one step.

    Raises:
        InputError: if it cannot be written.
    """
    folder = output / ROWS
    folder.mkdir(exist_ok=True)
    target = folder / f"{verb}.parquet"
    with replacing(target) as partial, pyarrow.parquet.ParquetWriter(partial, SCHEMA) as writer:
        for batch in _batches(sorted(tasks, key=lambda task: (task.recording, task.damper))):
            writer.write_table(pyarrow.Table.from_pylist(batch, SCHEMA))
    return target


def _batches(tasks: Iterable[Task]) -> Iterator[list[dict[str, object]]]:
    batch: list[dict[str, object]] = []
    for task in tasks:
        row = stored_row(task)
        if row is not None:
            # The vehicle is only a label: it does not affect results.
            batch.append(_typed(row | {"vehicle": task.facts["vehicle"]}))
        if len(batch) == _BATCH:
            yield batch
            batch = []
    yield batch


def _typed(row: dict[str, object]) -> dict[str, object]:
    maps = {name: list(row[name].items()) for name in ("parameters", "standard_errors") if row.get(name) is not None}
    return row | maps


def read_rows(output: Path) -> dict[str, list[dict[str, object]]]:
    """The rows in a folder by verb; times in ns."""
    found = {}
    for path in sorted((output / ROWS).glob("*.parquet")):
        table = pyarrow.parquet.read_table(path, schema=SCHEMA)
        begin = table.column("begin").cast(_COUNT)
        table = table.set_column(table.schema.get_field_index("begin"), "begin", begin)
        found[path.stem] = table.to_pylist(maps_as_pydicts="strict")
    return found


def failures_of(rows: Path) -> list[dict[str, str]]:
    """Recording, damper and reason of the rows that failed."""
    return _filtered(rows, "reason", [("status", "==", FAILED)])


def spoiled_of(rows: Path) -> list[dict[str, str]]:
    """Recording, damper and fault of the rows whose results mean nothing before the recording is corrected."""
    return _filtered(rows, "spoiled", [("spoiled", "!=", "")])


def _filtered(rows: Path, text: str, conditions: list[tuple[str, str, str]]) -> list[dict[str, str]]:
    names = ["recording", "damper", text]
    return pyarrow.parquet.read_table(rows, columns=names, filters=conditions).to_pylist()
