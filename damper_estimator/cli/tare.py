"""Find standstill in a recording, and zero gauge and displacement in a signal map.

At rest, displacement and force vary by no more than their noise for at least half a second. The offsets are set so
that displacement and damper force are zero in the longest rest: the gauge then shows its offset and the spring's
preload. Everything else in the map given with -s is kept.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from damper_estimator.cli.verb_support import add_bags, add_json, add_signals, prints_text, write_json
from damper_estimator.signals import load_signal_map, save_signal_map
from damper_estimator.workflows import tare

EXAMPLES = (
    "tare hidden_fit.mcap -o map.yaml",
    "tare four_corners_road.mcap -d front_left -o map.yaml",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG -o MAP.yaml`` and the common arguments."""
    add_bags(parser, several=False)
    parser.add_argument("-o", "--output", metavar="MAP.yaml", type=Path, required=True, help="the signal map to write")
    add_signals(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Tares the dampers of a recording."""
    found = tare(arguments.bag, load_signal_map(arguments.signals), arguments.dampers)
    save_signal_map(found.signal_map, arguments.output)
    records = found.to_dict()
    write_json(arguments.json, records)
    if prints_text(arguments):
        _print(records["dampers"])
        print(f"wrote {arguments.output}")
    return 0


def _print(records: Mapping[str, dict]) -> None:
    for name, record in records.items():
        rest = record["rest"]
        line = f"{name}: rest from {rest['from']:.1f} to {rest['to']:.1f} s; "
        line += f"displacement was {1e3 * record['displacement_was_m']:.4g} mm"
        if np.isfinite(record["force_was_n"]):
            line += f", the damper's force {record['force_was_n']:.4g} N"
        print(f"{line}; both are zero there now")
        for other in record["other_rests"][:5]:
            force = f" and {other['force_n']:+.3g} N" if np.isfinite(other["force_n"]) else ""
            print(
                f"  another rest, {other['from']:.1f} to {other['to']:.1f} s, reads "
                f"{1e3 * other['displacement_m']:+.3g} mm{force} relative to it"
            )
