"""Inspect a recording: contents, quality, a proposed signal map, and whether it can identify a damper.

Faults of the measurement chain that the recording alone reveals (a gauge that clips or drifts, gaps, wrong signs,
clocks that diverge, ...) are reported with remedies.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from damper_estimator.cli.data_finding_text import print_findings
from damper_estimator.cli.verb_support import add_bags, add_json, add_signals, prints_text, write_json
from damper_estimator.errors import InputError
from damper_estimator.signals import load_signal_map, save_signal_map
from damper_estimator.workflows import DamperInspected, Inspection, inspect

EXAMPLES = (
    "inspect hidden_fit.mcap",
    "inspect four_corners_road.mcap -o map.yaml --json -",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG [-o MAP.yaml]`` and the common arguments."""
    add_bags(parser, several=False)
    parser.add_argument(
        "-o", "--output", metavar="MAP.yaml", type=Path, help="write the signal map that was used or proposed"
    )
    add_signals(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Inspects a recording."""
    given = None if arguments.signals is None else load_signal_map(arguments.signals)
    found = inspect(arguments.bag, given, arguments.dampers)
    if arguments.output is not None:
        if not found.signal_map.dampers:
            raise InputError(
                f"{arguments.bag}: no displacement was recognised, so no signal map can be proposed; write one"
            )
        save_signal_map(found.signal_map, arguments.output)
    write_json(arguments.json, found.to_dict())
    if prints_text(arguments):
        _print(found)
        if arguments.output is not None:
            print(f"wrote {arguments.output}")
    return 0


def _print(found: Inspection) -> None:
    width = max((len(topic.name) for topic in found.topics), default=0)
    for topic in found.topics:
        rate = f"{topic.rate_hz:8.1f} Hz" if np.isfinite(topic.rate_hz) else ""
        print(f"{topic.name:{width}}  {topic.messages:8d}  {rate:11}  {topic.type}")
    if found.guesses:
        print("guessed:")
        for guess in found.guesses:
            print(f"  {guess}")
    if not found.dampers:
        print("no displacement was recognised; write a signal map (topic and field of each channel)")
    for name, damper in found.dampers.items():
        _print_damper(name, damper)


def _print_damper(name: str, found: DamperInspected) -> None:
    verdict = found.verdict
    print(f"{name}: {'good enough to identify a damper' if verdict.good else 'not good enough to identify a damper'}")
    for role, factor, unit in (("displacement", 1e3, "mm"), ("force", 1.0, "N")):
        if role in found.quality:
            q = found.quality[role]
            faults = {"gaps": q.gaps, "steps back": q.steps_back, "older": q.inversions, "equal": q.duplicates}
            faults |= {"not finite": q.non_finite, "spikes": q.spikes, "saturated": q.saturated}
            fault_text = ", ".join(f"{count} {kind}" for kind, count in faults.items() if count) or "no faults"
            print(
                f"  {role}: {q.samples} samples at {q.rate_hz:.4g} Hz (jitter {1e3 * q.jitter_s:.2g} ms), "
                f"{factor * q.low:.4g} to {factor * q.high:.4g} {unit}, steps of {factor * q.quantum:.2g}, noise "
                f"{factor * q.noise:.2g} {unit}; {fault_text}"
            )
    _print_excitation(found.excitation.record())
    print_findings(found.findings)
    for kind, texts in (("fault", verdict.faults), ("remark", verdict.remarks), ("drive next", verdict.drive_next)):
        for text in texts:
            print(f"  {kind}: {text}")
    if verdict.good:
        print("  when a model is fitted: damper-estimator plan --parameters designs a test that makes it more certain")


def _print_excitation(e: Mapping[str, object]) -> None:
    (low_v, high_v), (low_a, high_a), (low_f, high_f) = e["velocity"], e["acceleration"], e["frequency"]
    print(
        f"  motion: {e['seconds']:.1f} s, {low_v:.3g} to {high_v:.3g} m/s, {low_a:.3g} to {high_a:.3g} m/s^2, "
        f"{low_f:.2g} to {high_f:.2g} Hz, {100 * e['coverage']:.0f} % of the velocity-displacement plane"
    )
