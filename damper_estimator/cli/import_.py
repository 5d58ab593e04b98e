"""Turn bench and logger files (CSV, text, MAT) into recordings, by a column map.

A column map (YAML) says which column is which channel, in which unit, at which rate, and where a file falls into parts;
config/columns/example.yaml explains every key. Several parts (or files) go into a folder, a single one may be an .mcap.
"""

import argparse
from pathlib import Path

import numpy as np

from damper_estimator.cli.common import STANDARD_OUTPUT, add_json, progress, write_json
from damper_estimator.recordings import Part
from damper_estimator.workflows import import_files


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares FILE..., --columns, -o and --json."""
    parser.add_argument("files", metavar="FILE", nargs="+", type=Path, help="a CSV, text or MAT file, gzip or not")
    parser.add_argument(
        "--columns", metavar="MAP.yaml", required=True, help="column map: a file, or the name of one in config/columns"
    )
    parser.add_argument(
        "-o", "--output", metavar="BAG", type=Path, required=True, help="a folder, or an .mcap for a single part"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Reads every file before it writes the first recording, so that a bad one leaves nothing behind."""
    imported = import_files(arguments.files, arguments.columns, arguments.output, progress)
    for own in imported if arguments.json != STANDARD_OUTPUT else ():
        print(_line(own.part, own.path))
    write_json(arguments.json, {"parts": [own.record() for own in imported]})
    return 0


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
