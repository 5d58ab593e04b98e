"""Inspects a recording: contents, quality, a proposed signal map, and whether it can identify a damper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings import Bag, open_bag
from damper_estimator.signals import (
    DEFAULT_MAX_GAP,
    Measurement,
    Rest,
    SignalMap,
    check_force,
    measure,
    read_channels,
    signals_for,
)
from damper_estimator.validation import (
    ChannelQuality,
    DataFinding,
    Excitation,
    Verdict,
    channel_quality,
    data_findings,
    excitation,
    verdict,
)
from damper_estimator.workflows.map_proposal import propose
from damper_estimator.workflows.taring import rests_in


@dataclass(frozen=True)
class TopicFacts:
    """A topic: name, type, number of messages, and their rate in Hz by log time (NaN for fewer than two)."""

    name: str
    type: str
    messages: int
    rate_hz: float


@dataclass(frozen=True)
class DamperInspected:
    """One damper.

    Attributes:
        quality: of displacement and force by role, if recorded.
        excitation: its motion.
        ranges: smallest and largest value of each slow channel, by role.
        rests: periods of standstill.
        findings: faults of the measurement chain that the recording alone reveals.
        verdict: whether it can identify a damper, and which test to drive next.
    """

    quality: Mapping[str, ChannelQuality]
    excitation: Excitation
    ranges: Mapping[str, tuple[float, float]]
    rests: tuple[Rest, ...]
    findings: tuple[DataFinding, ...]
    verdict: Verdict

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {
            **{role: quality.record() for role, quality in self.quality.items()},
            "excitation": self.excitation.record(),
            "ranges": {role: list(ends) for role, ends in self.ranges.items()},
            "rests": [{"from": rest.start, "to": rest.end} for rest in self.rests],
            "findings": [finding.record() for finding in self.findings],
            "verdict": self.verdict.record(),
        }


@dataclass(frozen=True)
class Inspection:
    """A recording: its topics, the signal map used or proposed, the guesses behind it, and its dampers."""

    topics: tuple[TopicFacts, ...]
    signal_map: SignalMap
    guesses: tuple[str, ...]
    dampers: Mapping[str, DamperInspected]

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "topics": [asdict(topic) for topic in self.topics],
            "guesses": self.guesses,
            "dampers": {name: damper.record() for name, damper in self.dampers.items()},
        }


def inspect(path: Path, signal_map: SignalMap | None = None, dampers: Sequence[str] = ()) -> Inspection:
    """Inspects a recording.

    Args:
        signal_map: None proposes one.
        dampers: names; empty for all.

    Raises:
        InputError: for an unreadable recording, and for dampers that it does not have.
    """
    with open_bag(path) as bag:
        topics = _topics(bag)
        if signal_map is None:
            proposal = propose(bag)
            used, guesses = proposal.signal_map, proposal.guesses
        else:
            used, guesses = signals_for(bag, signal_map), ()
        for name in dampers:
            signals_for(bag, used, name)
        names = [name for name in used.dampers if not dampers or name in dampers]
        return Inspection(topics, used, guesses, {name: _inspected(bag, used, name) for name in names})


def _topics(bag: Bag) -> tuple[TopicFacts, ...]:
    ends: dict[str, tuple[int, int]] = {}
    for batch in bag.batches():
        for connection, log, _ in batch.raw():
            first, last = ends.get(connection.topic, (log, log))
            ends[connection.topic] = (min(first, log), max(last, log))
    topics = []
    for topic in bag.topics:
        first, last = ends.get(topic.name, (0, 0))
        rate = (topic.messages - 1) / ((last - first) * 1e-9) if last > first else float("nan")
        topics.append(TopicFacts(topic.name, topic.type, topic.messages, rate))
    return tuple(topics)


def _misses(measurement: Measurement) -> str:
    """Why the force cannot be compared with the motion; "" if it can, or if there is none."""
    try:
        if measurement.force is not None:
            check_force(measurement)
    except InputError as error:
        return str(error).removeprefix(f"{measurement.recording}: ")
    return ""


def _inspected(bag: Bag, signal_map: SignalMap, name: str) -> DamperInspected:
    signals = signal_map.dampers[name]
    data = read_channels(bag, signals.channels())
    if "displacement" not in data:
        raise InputError(
            f"{bag.path}: has no displacement of damper {name!r} ({signals.displacement.topic}, "
            f"{signals.displacement.field})"
        )
    quality = {
        role: channel_quality(channel.stamp, channel.value, DEFAULT_MAX_GAP)
        for role, channel in data.items()
        if role in ("displacement", "force")
    }
    measurement = measure(bag, signal_map, name, force_wanted=False)
    quality = {role: replace(one, spikes=len(measurement.spikes.get(role, ()))) for role, one in quality.items()}
    motion, findings = excitation(measurement), data_findings(None, [measurement])
    rests = rests_in(data)
    ranges = {
        role: (float(np.nanmin(channel.value)), float(np.nanmax(channel.value)))
        for role, channel in data.items()
        if role not in quality
    }
    judged = verdict(motion, quality["displacement"], quality.get("force"), bool(rests), findings, _misses(measurement))
    return DamperInspected(quality, motion, ranges, rests, tuple(findings), judged)
