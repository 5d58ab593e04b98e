"""Run a model over a recording exactly as the node does, and write the estimates together with their inputs.

Samples are processed in order of arrival, and slow channels hold their last value, so the forces equal those of the
node bit for bit. The output contains the topics of the signal map unchanged, ``/damper_estimator/force`` (one message
per displacement message with an estimate, with the same log time and stamp) and, if the force was measured,
``/damper_estimator/residual`` (effort = model - measured). An existing output is replaced.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

from damper_estimator.cli.verb_support import (
    above_zero,
    add_bags,
    add_json,
    add_models,
    add_signals,
    add_window,
    prints_text,
    progress,
    write_json,
)
from damper_estimator.signals import DEFAULT_MAX_GAP, load_signal_map
from damper_estimator.workflows import ReplayCounts, ReplayOptions, replay_to

EXAMPLES = (
    "replay hidden_unseen.mcap -m mine.yaml -o replayed.mcap",
    "replay four_corners_road.mcap -m viscous_curve -d front_left -o replayed.mcap",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG -m MODEL -o BAG`` and the common arguments."""
    add_bags(parser, several=False)
    add_models(parser)
    parser.add_argument("-o", "--output", metavar="BAG", type=Path, required=True, help="the .mcap file to write")
    add_signals(parser)
    add_window(parser)
    parser.add_argument(
        "--max-gap",
        metavar="S",
        type=above_zero,
        default=DEFAULT_MAX_GAP,
        help="a longer gap between stamps resets the state (%(default)g s)",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Replays one recording."""
    options = ReplayOptions(tuple(arguments.dampers), arguments.start, arguments.stop, arguments.max_gap)
    signal_map = load_signal_map(arguments.signals)
    tallies = replay_to(arguments.bag, arguments.model, arguments.output, signal_map, options, progress)
    records = {name: tally.record() for name, tally in tallies.items()}
    write_json(arguments.json, {"output": str(arguments.output), "dampers": records})
    if prints_text(arguments):
        _print(tallies, arguments.output)
    return 0


def _print(tallies: Mapping[str, ReplayCounts], output: Path) -> None:
    for name, tally in tallies.items():
        counts = tally.counts
        lost = {"equal stamps": counts.duplicates, "older stamps": counts.inversions, "not finite": counts.non_finite}
        dropped = ", ".join(f"{count} {kind}" for kind, count in lost.items() if count)
        resets = ", ".join(
            f"{n} {kind}" for kind, n in {"gaps": counts.gaps, "steps back": counts.steps_back}.items() if n
        )
        line = f"{name}: {tally.estimates} estimates of {counts.samples} samples"
        line += f"; dropped {dropped}" if dropped else ""
        line += f"; reset by {resets}" if resets else ""
        line += f"; {tally.not_finite} forces are not finite" if tally.not_finite else ""
        if tally.residuals:
            line += f"; residual {tally.residual_rms_n:.4g} N rms"
        print(line)
    print(f"wrote {output}")
