"""Convert bench and logger files (CSV, text, MAT) to recordings with a given or guessed column map.

A column map (YAML) states channel and unit of each column, the sample rate, and how to split a file into parts;
config/columns/example.yaml explains every key. Several parts (or files) need a folder, a single one may be an .mcap.
--guess derives the map from titles, units, ranges, slopes and the sign of power, and writes it next to the output
together with a preview page; doubtful guesses are not imported.
"""

import argparse
from pathlib import Path

import numpy as np

from damper_estimator.cli.verb_support import add_json, prints_text, progress, write_json
from damper_estimator.recordings import Part
from damper_estimator.report import column_rows
from damper_estimator.workflows import Guessed, guess_files, import_files, import_guessed

EXAMPLES = (
    "import bench.csv --guess -o bench.mcap",
    "import bench.csv --columns bench_columns.yaml -o bench.mcap",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    parser.add_argument(
        "files", metavar="FILE", nargs="+", type=Path, help="a CSV, text or MAT file, optionally gzipped"
    )
    rules = parser.add_mutually_exclusive_group(required=True)
    rules.add_argument("--columns", metavar="MAP.yaml", help="column map: a file, or the name of one in config/columns")
    rules.add_argument(
        "--guess", action="store_true",
        help="guess the map; writes STEM_columns.yaml and STEM_preview.html next to the output",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", metavar="BAG", type=Path, required=True, help="a folder, or an .mcap for a single part"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Reads every file before it writes the first recording, so that an unusable file leaves no output."""
    with_text = prints_text(arguments)
    if arguments.guess:
        guessed = guess_files(arguments.files, arguments.output)
        for file in guessed if with_text else ():
            print("\n".join(_guess_lines(file)))
        imported = import_guessed(guessed, arguments.output)
    else:
        imported = import_files(arguments.files, arguments.columns, arguments.output, progress)
    for recording in imported if with_text else ():
        print(_line(recording.part, recording.path))
    write_json(arguments.json, {"parts": [recording.record() for recording in imported]})
    return 0


def _guess_lines(guessed: Guessed) -> list[str]:
    """Interpretation of a file's columns, with assumptions and doubts."""
    lines = [f"{guessed.guess.path}: guessed, see {guessed.columns} and {guessed.page}"]
    for title, channel, unit, _ in column_rows(guessed.guess):
        lines.append(f"  {title}: {channel}{f' in {unit}' if unit else ''}")
    lines += [f"  assumed: {text}" for text in guessed.guess.assumed]
    return lines + [f"  in doubt: {text}" for text in guessed.guess.doubts]


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
