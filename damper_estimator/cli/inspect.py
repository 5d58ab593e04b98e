"""What is in a recording, how good it is, a proposed signal map, and whether it can identify a damper.

Mistakes of the measurement chain that the recording shows by itself (a gauge that clips or drifts, gaps, wrong signs,
clocks that run apart, ...) are named, with what mends them.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from damper_estimator.cli.common import add_bags, add_json, add_signals, write_json
from damper_estimator.cli.data_findings import print_findings
from damper_estimator.cli.map_proposal import propose
from damper_estimator.errors import InputError
from damper_estimator.recordings import Bag, open_bag
from damper_estimator.signals import DEFAULT_MAX_GAP, SignalMap, load_signal_map, measure, save_signal_map
from damper_estimator.signals.channels import read_channels, signals_for
from damper_estimator.signals.rest import find_rests
from damper_estimator.validation import DataFinding, data_findings
from damper_estimator.validation.channel_quality import channel_quality
from damper_estimator.validation.suitability import excitation, verdict


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG [-o MAP.yaml]`` and what is common."""
    add_bags(parser, several=False)
    parser.add_argument(
        "-o", "--output", metavar="MAP.yaml", type=Path, help="write the signal map that was used or proposed"
    )
    add_signals(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Inspects; see the module's docstring."""
    with open_bag(arguments.bag) as bag:
        topics = _topics(bag)
        signal_map, guesses = _map(bag, arguments.signals)
        for name in arguments.dampers:
            signals_for(bag, signal_map, name)
        names = [name for name in signal_map.dampers if not arguments.dampers or name in arguments.dampers]
        dampers = {name: _inspected(bag, signal_map, name) for name in names}
    if arguments.output is not None:
        if not signal_map.dampers:
            raise InputError(
                f"{arguments.bag}: no displacement was recognised, so no signal map can be proposed; write one by hand"
            )
        save_signal_map(signal_map, arguments.output)
    write_json(arguments.json, {"topics": topics, "guesses": guesses, "dampers": dampers})
    if arguments.json != "-":
        _print(topics, guesses, dampers)
        if arguments.output is not None:
            print(f"wrote {arguments.output}")
    return 0


def _topics(bag: Bag) -> list[dict[str, object]]:
    """Name, type, count and rate (by log time) of each topic."""
    ends: dict[str, tuple[int, int]] = {}
    for batch in bag.batches():
        for connection, log, _ in batch.raw():
            first, last = ends.get(connection.topic, (log, log))
            ends[connection.topic] = (min(first, log), max(last, log))
    topics = []
    for topic in bag.topics:
        first, last = ends.get(topic.name, (0, 0))
        rate = (topic.messages - 1) / ((last - first) * 1e-9) if last > first else float("nan")
        topics.append({"name": topic.name, "type": topic.type, "messages": topic.messages, "rate_hz": rate})
    return topics


def _map(bag: Bag, path: Path | None) -> tuple[SignalMap, tuple[str, ...]]:
    if path is not None:
        return signals_for(bag, load_signal_map(path)), ()
    proposal = propose(bag)
    return proposal.signal_map, proposal.guesses


def _inspected(bag: Bag, signal_map: SignalMap, name: str) -> dict[str, object]:
    signals = signal_map.dampers[name]
    data = read_channels(bag, signals.channels())
    if "displacement" not in data:
        raise InputError(
            f"{bag.path}: has no displacement of damper {name!r} ({signals.displacement.topic}, "
            f"{signals.displacement.field})"
        )
    quality = {
        role: channel_quality(own.stamp, own.value, DEFAULT_MAX_GAP)
        for role, own in data.items()
        if role in ("displacement", "force")
    }
    measurement = measure(bag, signal_map, name, force_wanted=False)
    moved, findings = excitation(measurement), data_findings(None, [measurement])
    ordered = [array for role in quality for array in _ordered(data[role].stamp, data[role].value)]
    rests = find_rests(*ordered)
    slow = {
        role: [float(np.nanmin(own.value)), float(np.nanmax(own.value))]
        for role, own in data.items()
        if role not in quality
    }
    return {
        **{role: own.record() for role, own in quality.items()},
        "excitation": moved.record(),
        "ranges": slow,
        "rests": [{"from": rest.start, "to": rest.end} for rest in rests],
        "findings": [finding.record() for finding in findings],
        "verdict": verdict(moved, quality["displacement"], quality.get("force"), bool(rests)).record(),
    }


def _ordered(stamp: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    good = np.isfinite(value)
    order = np.argsort(stamp[good], kind="stable")
    return stamp[good][order], value[good][order]


def _print(topics: list, guesses: tuple[str, ...], dampers: Mapping[str, dict]) -> None:
    width = max((len(t["name"]) for t in topics), default=0)
    for t in topics:
        rate = f"{t['rate_hz']:8.1f} Hz" if np.isfinite(t["rate_hz"]) else ""
        print(f"{t['name']:{width}}  {t['messages']:8d}  {rate:11}  {t['type']}")
    if guesses:
        print("guessed:")
        for guess in guesses:
            print(f"  {guess}")
    if not dampers:
        print("no displacement was recognised; write a signal map (topic and field of each channel)")
    for name, record in dampers.items():
        _print_damper(name, record)


def _print_damper(name: str, record: Mapping[str, dict]) -> None:
    judged = record["verdict"]
    print(f"{name}: {'good enough to identify a damper' if judged['good'] else 'not good enough to identify a damper'}")
    for role, factor, unit in (("displacement", 1e3, "mm"), ("force", 1.0, "N")):
        if role in record:
            q = record[role]
            faults = {
                "gaps": q["gaps"],
                "steps back": q["steps_back"],
                "older": q["inversions"],
                "equal": q["duplicates"],
            }
            faults |= {"not finite": q["non_finite"], "saturated": q["saturated"]}
            told = ", ".join(f"{count} {what}" for what, count in faults.items() if count) or "no faults"
            print(
                f"  {role}: {q['samples']} samples at {q['rate_hz']:.4g} Hz (jitter {1e3 * q['jitter_s']:.2g} "
                f"ms), {factor * q['low']:.4g} to "
                f"{factor * q['high']:.4g} {unit}, steps of {factor * q['quantum']:.2g}, noise "
                f"{factor * q['noise']:.2g} {unit}; {told}"
            )
    _print_excitation(record["excitation"])
    print_findings([DataFinding(**own) for own in record["findings"]])
    for kind in ("faults", "remarks"):
        for text in judged[kind]:
            print(f"  {kind[:-1]}: {text}")
    for text in judged["drive_next"]:
        print(f"  drive next: {text}")


def _print_excitation(e: Mapping[str, object]) -> None:
    (low_v, high_v), (low_a, high_a), (low_f, high_f) = e["velocity"], e["acceleration"], e["frequency"]
    print(
        f"  motion: {e['seconds']:.1f} s, {low_v:.3g} to {high_v:.3g} m/s, {low_a:.3g} to {high_a:.3g} m/s^2, "
        f"{low_f:.2g} to {high_f:.2g} Hz, {100 * e['coverage']:.0f} % of the velocity-displacement plane"
    )
