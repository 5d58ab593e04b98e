"""The form in which a guessed column map is corrected: from a guess to rows, from what was chosen to a column map."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from dash import dcc, html

from damper_estimator.errors import InputError
from damper_estimator.recordings import Guess, Part, column_map_of, guess_columns, planned_paths, read_parts, write_part
from damper_estimator.recordings.quantities import QUANTITIES, TIME_UNITS
from damper_estimator.studio.folder import BENCH, Folder

MOST = 60  # columns that are shown
_OUT = "left out"


def guessed(folder: Folder, name: str) -> Guess:
    """The guess for a bench file of the folder.

    Raises:
        InputError: where it cannot be read.
    """
    return guess_columns(folder.existing(name, BENCH))


def form(guess: Guess) -> list:
    """One row per column: what it is, in which unit, and whether its sign is turned round."""
    dampers = sorted({column.damper for column in guess.columns if column.damper}) or ["damper"]
    options = [_OUT, *(f"time in {unit}" for unit in TIME_UNITS)]
    options += [f"{d} {q} in {unit}" for d in dampers for q, quantity in QUANTITIES.items() for unit in quantity.units]
    rows = []
    for i, column in enumerate(guess.columns[:MOST]):
        name = f"{column.title or f'column {column.column}'}"
        chosen = dcc.Dropdown(options, _chosen(guess, i), id={"type": "bench-column", "index": i}, clearable=False)
        turned = dcc.Checklist(
            [{"label": "turn round", "value": "turn"}], ["turn"] if column.scale < 0 else [],
            id={"type": "bench-turn", "index": i},
        )  # fmt: skip
        cells = [html.Th(name, scope="row"), html.Td(chosen), html.Td(turned), html.Td(column.why, className="hint")]
        rows.append(html.Tr(cells))
    head = html.Thead(html.Tr([html.Th(text, scope="col") for text in ("column", "is", "sign", "because of")]))
    return [_notes("To decide", guess.doubts, "warning"), _notes("Assumed", guess.assumed, "hint"),
            html.Table([head, html.Tbody(rows)], className="bench")]  # fmt: skip


def kept(guess: Guess, name: str) -> dict[str, object]:
    """What the page keeps of a guess while it is corrected."""
    columns = [column.column for column in guess.columns[:MOST]]
    return {
        "file": name,
        "columns": columns,
        "time": dict(guess.time),
        "text": dict(guess.text),
        "split": dict(guess.split),
    }


def corrected(data: object, chosen: Sequence[object], turned: Sequence[object]) -> dict[str, object]:
    """The column map that the form says.

    Raises:
        InputError: where it is not complete, such as without a displacement; or two columns are the same.
    """
    entries = dict(data) if isinstance(data, Mapping) else {}
    columns = entries.get("columns")
    if not isinstance(columns, list) or not len(columns) == len(chosen) == len(turned):
        raise InputError("the form is not that of a file; choose the file again")
    dampers: dict[str, dict[str, object]] = {}
    time = (
        entries.get("time")
        if "column" not in dict(entries.get("time") or {}) or "format" in dict(entries["time"])
        else None
    )
    for column, what, turn in zip(columns, map(str, chosen), turned, strict=True):
        name, _, unit = what.rpartition(" in ")
        if what == _OUT:
            continue
        if name == "time":
            time = {"column": column, "unit": unit}
            continue
        damper, _, quantity = name.rpartition(" ")
        if quantity in dampers.setdefault(damper, {}):
            raise InputError(f"two columns are the {quantity} of {damper}; leave one of them out")
        dampers[damper][quantity] = {"column": column, "unit": unit} | ({"scale": -1.0} if turn else {})
    content = {"dampers": dampers, "time": time, "text": entries.get("text"), "split": entries.get("split")}
    return {key: value for key, value in content.items() if value}


def parts_of(folder: Folder, name: object, content: Mapping) -> list[Part]:
    """The recordings that a column map makes of a file.

    Raises:
        InputError: where the map and the file do not go together.
    """
    path = folder.existing(name, BENCH)
    return read_parts(path, column_map_of(content, f"columns of {path.name}"))


def imported(folder: Folder, parts: Sequence[Part]) -> list[str]:
    """Writes the recordings next to their file; returns their names.

    Raises:
        InputError: where one of them exists, or cannot be written.
    """
    place = parts[0].source.parent
    names = [str(path.relative_to(folder.root)) for path in planned_paths(parts, [None] * len(parts), place)]
    targets: list[Path] = [folder.target(name, ".mcap", replace=False) for name in names]
    for part, target in zip(parts, targets, strict=True):
        write_part(part, target)
    return names


def _chosen(guess: Guess, index: int) -> str:
    column = guess.columns[index]
    if column.quantity == "time":
        return f"time in {guess.time.get('unit', 's')}" if "format" not in guess.time else _OUT
    return f"{column.damper} {column.quantity} in {column.unit}" if column.quantity in QUANTITIES else _OUT


def _notes(title: str, texts: Sequence[str], kind: str) -> html.Div:
    rows = [html.P([html.B(f"{title}: "), text], className=kind) for text in texts]
    return html.Div(rows)
