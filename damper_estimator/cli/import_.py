"""Turn bench and logger files (CSV, text, MAT) into recordings, by a column map.

A column map (YAML) says which column is which channel, in which unit, at which rate, and where a file falls into parts;
config/columns/example.yaml explains every key. Several parts (or files) go into a folder, a single one may be an .mcap.
"""

import argparse
from pathlib import Path

import numpy as np

from damper_estimator.cli.common import STANDARD_OUTPUT, add_json, progress, write_json
from damper_estimator.errors import InputError
from damper_estimator.recordings import Part, load_column_maps, planned_paths, read_parts, write_part


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
    maps = load_column_maps(arguments.columns)
    parts: list[Part] = []
    templates: list[str | None] = []
    for path in arguments.files:
        rules = maps.for_file(path.name)
        found = read_parts(path, rules)
        progress(f"{path}: {len(found)} part{'s' if len(found) > 1 else ''}")
        parts += found
        templates += [rules.name] * len(found)
    paths = planned_paths(parts, templates, arguments.output)
    _make_folder(arguments.output)
    for part, path in zip(parts, paths, strict=True):
        write_part(part, path)
        if arguments.json != STANDARD_OUTPUT:
            print(_line(part, path))
    write_json(arguments.json, {"parts": [_facts(part, path) for part, path in zip(parts, paths, strict=True)]})
    return 0


def _make_folder(output: Path) -> None:
    if output.suffix == ".mcap":
        return
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{output}: cannot be made ({error.strerror}); choose another folder with -o") from error


def _facts(part: Part, path: Path) -> dict:
    """A part for the JSON: ranges in the units that the bag holds."""
    return {
        "file": path,
        "source": part.source,
        "part": part.number,
        "samples": len(part.stamps),
        "rate_hz": part.rate,
        "duration_s": part.duration,
        "dampers": {
            damper: {
                name: {"min": np.nanmin(values), "max": np.nanmax(values), "unit": part.units[damper][name]}
                for name, values in channels.items()
            }
            for damper, channels in part.dampers.items()
        },
        "notes": part.notes,
    }


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
