"""Turn bench and logger files (CSV, text, MAT) into recordings, by a column map that is given or guessed.

A column map (YAML) says which column is which channel, in which unit, at which rate, and where a file falls into parts;
config/columns/example.yaml explains every key. Several parts (or files) go into a folder, a single one may be an .mcap.
With --guess the map is guessed from titles, units, ranges, slopes and the sign of power, and written beside the output
with a page that shows what it makes of the file; nothing is imported while something is in doubt.
"""

import argparse
from pathlib import Path

import numpy as np

from damper_estimator.cli.common import STANDARD_OUTPUT, add_json, progress, write_json
from damper_estimator.recordings import Part
from damper_estimator.report import column_rows
from damper_estimator.workflows import Guessed, guess_files, import_files, import_guessed

EXAMPLES = (
    "import bench.csv --guess -o bench.mcap",
    "import bench.csv --columns bench_columns.yaml -o bench.mcap",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares FILE..., --columns, -o and --json."""
    parser.add_argument("files", metavar="FILE", nargs="+", type=Path, help="a CSV, text or MAT file, gzip or not")
    rules = parser.add_mutually_exclusive_group(required=True)
    rules.add_argument("--columns", metavar="MAP.yaml", help="column map: a file, or the name of one in config/columns")
    rules.add_argument(
        "--guess", action="store_true",
        help="guess the map; writes STEM_columns.yaml and STEM_preview.html beside the output",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", metavar="BAG", type=Path, required=True, help="a folder, or an .mcap for a single part"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Reads every file before it writes the first recording, so that a bad one leaves nothing behind."""
    silent = arguments.json == STANDARD_OUTPUT
    if arguments.guess:
        guessed = guess_files(arguments.files, arguments.output)
        for own in guessed if not silent else ():
            print("\n".join(_guess_lines(own)))
        imported = import_guessed(guessed, arguments.output)
    else:
        imported = import_files(arguments.files, arguments.columns, arguments.output, progress)
    for own in imported if not silent else ():
        print(_line(own.part, own.path))
    write_json(arguments.json, {"parts": [own.record() for own in imported]})
    return 0


def _guess_lines(own: Guessed) -> list[str]:
    """What a file's columns are taken for, what is assumed and what is in doubt."""
    lines = [f"{own.guess.path}: guessed, see {own.columns} and {own.page}"]
    for title, what, unit, _ in column_rows(own.guess):
        lines.append(f"  {title}: {what}{f' in {unit}' if unit else ''}")
    lines += [f"  assumed: {text}" for text in own.guess.assumed]
    return lines + [f"  in doubt: {text}" for text in own.guess.doubts]


def _line(part: Part, path: Path) -> str:
    """A part on one line."""
    ranges = [
        f"{damper} {name} {_range(values)} {part.units[damper][name]}"
        for damper, channels in part.dampers.items()
        for name, values in channels.items()
    ]
    size = f"{len(part.stamps)} samples, {part.rate:.6g} Hz, {part.duration:.4g} s"
    return f"{path}: {'; '.join([size, *ranges, *part.notes])}"


def _range(values: np.ndarray | float) -> str:
    low, high = np.nanmin(values), np.nanmax(values)
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
