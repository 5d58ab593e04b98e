"""Find rest in a recording, and zero gauge and displacement in a signal map.

At rest displacement and force are quiet for at least half a second, by their own noise. The longest rest counts. The
offsets are set so that there the displacement is zero and the damper's force is zero: what the gauge shows then is its
offset and the spring's preload. Everything else in the map given with -s is kept.
"""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from damper_estimator.cli.common import add_bags, add_json, add_signals, write_json
from damper_estimator.errors import InputError
from damper_estimator.recordings import Bag, open_bag
from damper_estimator.signals import Channel, DamperSignals, load_signal_map, save_signal_map
from damper_estimator.signals.channels import ChannelData, read_channels, signals_for
from damper_estimator.signals.rest import LEAST_SECONDS, Rest, find_rests


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG -o MAP.yaml`` and what is common."""
    add_bags(parser, several=False)
    parser.add_argument("-o", "--output", metavar="MAP.yaml", type=Path, required=True, help="the signal map to write")
    add_signals(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Tares; see the module's docstring."""
    signal_map = load_signal_map(arguments.signals)
    records = {}
    with open_bag(arguments.bag) as bag:
        whole = signals_for(bag, signal_map)
        for name in arguments.dampers:
            signals_for(bag, whole, name)
        dampers = dict(whole.dampers)
        for name in arguments.dampers or whole.dampers:
            dampers[name], rests = tared(bag, name, whole.dampers[name])
            records[name] = _record(rests, whole.dampers[name], dampers[name])
    save_signal_map(replace(whole, dampers=dampers), arguments.output)
    write_json(arguments.json, {"dampers": records})
    if arguments.json != "-":
        _print(records)
        print(f"wrote {arguments.output}")
    return 0


def tared(bag: Bag, name: str, signals: DamperSignals) -> tuple[DamperSignals, tuple[Rest, ...]]:
    """The damper's signals with offsets that make its longest rest zero, and all rests, the longest first.

    Raises:
        InputError: where there is no displacement, or no rest.
    """
    data = read_channels(bag, {"displacement": signals.displacement, "force": signals.force})
    if "displacement" not in data:
        raise InputError(
            f"{bag.path}: has no displacement of damper {name!r} ({signals.displacement.topic}); mend the signal map"
        )
    moved = _ordered(data["displacement"])
    force = _ordered(data["force"]) if "force" in data else (None, None)
    rests = sorted(find_rests(*moved, *force), key=lambda rest: -rest.seconds)
    if not rests:
        what = "displacement and force are" if "force" in data else "the displacement is"
        raise InputError(
            f"{bag.path}: damper {name} is never at rest ({what} nowhere quiet for {LEAST_SECONDS:g} s); "
            "record some seconds of standstill, or give offsets in the signal map"
        )
    zeroed = replace(signals, displacement=_shifted(signals.displacement, -rests[0].displacement))
    if "force" in data:
        zeroed = replace(zeroed, force=_shifted(signals.force, signals.preload - rests[0].force))
    return zeroed, tuple(rests)


def _ordered(data: ChannelData) -> tuple[np.ndarray, np.ndarray]:
    good = np.isfinite(data.value)
    order = np.argsort(data.stamp[good], kind="stable")
    return data.stamp[good][order], data.value[good][order]


def _shifted(channel: Channel, by: float) -> Channel:
    if channel.table is not None:
        raw, value = channel.table
        return replace(channel, table=(raw, tuple(float(v) + by for v in value)), given=True)
    return replace(channel, offset=float(channel.offset + by), given=True)


def _record(rests: tuple[Rest, ...], before: DamperSignals, after: DamperSignals) -> dict[str, object]:
    longest = rests[0]
    return {
        "rest": {"from": longest.start, "to": longest.end},
        "displacement_was_m": longest.displacement,
        "force_was_n": longest.force - before.preload,
        "displacement_offset": after.displacement.offset,
        "force_offset": after.force.offset,
        "other_rests": [
            {
                "from": r.start,
                "to": r.end,
                "displacement_m": r.displacement - longest.displacement,
                "force_n": r.force - longest.force,
            }
            for r in sorted(rests[1:], key=lambda rest: rest.start)
        ],
    }


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
                f"{1e3 * other['displacement_m']:+.3g} mm{force} beside it"
            )
