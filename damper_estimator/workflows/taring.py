"""Finds standstill in a recording, and zeroes gauge and displacement in a signal map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings import Bag, open_bag
from damper_estimator.signals import (
    LEAST_SECONDS,
    Channel,
    ChannelData,
    DamperSignals,
    Rest,
    SignalMap,
    displacement_course,
    find_rests,
    force_course,
    read_channels,
    signals_for,
)
from damper_estimator.validation import in_millimetres


@dataclass(frozen=True)
class Tared:
    """One damper: its rests, longest first, and its entry in the signal map before and after."""

    rests: tuple[Rest, ...]
    before: DamperSignals
    after: DamperSignals

    def record(self) -> dict[str, object]:
        """For JSON."""
        longest = self.rests[0]
        return {
            "rest": {"from": longest.start, "to": longest.end},
            "displacement_was_m": longest.displacement,
            "force_was_n": longest.force - self.before.preload,
            "displacement_offset": self.after.displacement.offset,
            "force_offset": self.after.force.offset,
            "other_rests": [
                {
                    "from": rest.start,
                    "to": rest.end,
                    "displacement_m": rest.displacement - longest.displacement,
                    "force_n": rest.force - longest.force,
                }
                for rest in sorted(self.rests[1:], key=lambda rest: rest.start)
            ],
        }


@dataclass(frozen=True)
class Tare:
    """The signal map with offsets that zero the longest rests, and the result of each damper."""

    signal_map: SignalMap
    dampers: Mapping[str, Tared]

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {"dampers": {name: tared.record() for name, tared in self.dampers.items()}}


def tare(path: Path, signal_map: SignalMap, dampers: Sequence[str] = ()) -> Tare:
    """Sets offsets so that in the longest rest the displacement is zero, and the damper's force as well.

    Args:
        dampers: names; empty for all. Others keep their entries.

    Raises:
        InputError: if there is no displacement or no rest, or the displacement is not in m.
    """
    with open_bag(path) as bag:
        whole = signals_for(bag, signal_map)
        for name in dampers:
            signals_for(bag, whole, name)
        found = {name: _tared(bag, name, whole.dampers[name]) for name in dampers or whole.dampers}
    entries = {**whole.dampers, **{name: tared.after for name, tared in found.items()}}
    return Tare(replace(whole, dampers=entries), found)


def _tared(bag: Bag, name: str, signals: DamperSignals) -> Tared:
    data = read_channels(bag, {"displacement": signals.displacement, "force": signals.force})
    if "displacement" not in data:
        raise InputError(
            f"{bag.path}: has no displacement of damper {name!r} ({signals.displacement.topic}); correct the signal map"
        )
    moved = data["displacement"].value
    if fault := in_millimetres(moved[np.isfinite(moved)], signals):
        raise InputError(f"{bag.path}: damper {name}: {fault}")
    rests = sorted(rests_in(data), key=lambda rest: -rest.seconds)
    if not rests:
        channels = "displacement and force are" if "force" in data else "the displacement is"
        raise InputError(
            f"{bag.path}: damper {name} is never at rest ({channels} nowhere quiet for {LEAST_SECONDS:g} s); "
            "record a few seconds of standstill, or state offsets in the signal map"
        )
    zeroed = replace(signals, displacement=_shifted(signals.displacement, -rests[0].displacement))
    if "force" in data:
        zeroed = replace(zeroed, force=_shifted(signals.force, signals.preload - rests[0].force))
    return Tared(tuple(rests), signals, zeroed)


def rests_in(data: Mapping[str, ChannelData]) -> tuple[Rest, ...]:
    """Rests of a damper from its channels, ``displacement`` and, if recorded, ``force``; without their spikes."""
    force = force_course(data["force"])[:2] if "force" in data else ()
    return find_rests(*displacement_course(data["displacement"])[:2], *force)


def _shifted(channel: Channel, by: float) -> Channel:
    if channel.table is not None:
        raw, value = channel.table
        return replace(channel, table=(raw, tuple(float(v) + by for v in value)), given=True)
    return replace(channel, offset=float(channel.offset + by), given=True)
