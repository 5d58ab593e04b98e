"""Inputs of a replay: values of all channels in order of arrival, from a bag in batches or from memory at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings import Bag, Batch, Part
from damper_estimator.runtime import SLOW, Arrivals
from damper_estimator.signals import Channel, SignalMap, find_topic, part_channels


@dataclass(frozen=True)
class Chunk:
    """The values of consecutive messages.

    Attributes:
        displacement, log: by damper, arrivals and the time at which each was recorded, (n,) int64 ns.
        slow: by damper and role.
        gauge: by damper, the measured force.
        batch: the messages themselves; None for samples in memory.
    """

    displacement: dict[str, Arrivals] = field(default_factory=dict)
    log: dict[str, np.ndarray] = field(default_factory=dict)
    slow: dict[str, dict[str, Arrivals]] = field(default_factory=dict)
    gauge: dict[str, Arrivals] = field(default_factory=dict)
    batch: Batch | None = None

    def add(self, damper: str, role: str, arrivals: Arrivals, log: np.ndarray) -> None:
        """Adds a channel."""
        if role == "displacement":
            self.displacement[damper], self.log[damper] = arrivals, log
        elif role == "force":
            self.gauge[damper] = arrivals
        else:
            self.slow.setdefault(damper, {})[role] = arrivals


class BagArrivals:
    """The channels of some dampers in a bag; final.

    Attributes:
        measured: dampers whose force channel is in the bag.
        messages: number of messages on the topics in use.
    """

    def __init__(self, bag: Bag, chosen: SignalMap, window: tuple[float, float]) -> None:
        """Raises InputError if the bag lacks a topic that the map names, or a displacement."""
        self._bag, self._dampers, self._window = bag, chosen.dampers, window
        self._fields: dict[str, list[tuple[str, str, Channel]]] = {}
        for name, signals in chosen.dampers.items():
            for role in roles(chosen):
                self._find(name, role, signals.channels()[role])
        entries = [entry for fields in self._fields.values() for entry in fields]
        self.measured = {name for name, role, _ in entries if role == "force"}
        self.messages = sum(topic.messages for topic in bag.topics if topic.name in self._fields)

    def _find(self, damper: str, role: str, channel: Channel) -> None:
        topic = find_topic(self._bag, channel.topic)
        if topic is not None:
            self._fields.setdefault(topic, []).append((damper, role, channel))
        elif channel.given or role == "displacement":
            topics = ", ".join(t.name for t in self._bag.topics) or "none"
            raise InputError(
                f"{self._bag.path}: has no topic {channel.topic} ({damper}, {role}); it has {topics}; correct the "
                "signal map"
            )

    def chunks(self, size: int) -> Iterator[Chunk]:
        """All messages, at most ``size`` of them in a chunk."""
        origin: int | None = None
        for batch in self._bag.batches(list(self._fields), size):
            if origin is None and len(batch):
                origin = int(batch.log.min())
            chunk = Chunk(batch=batch)
            for topic, entries in self._fields.items():
                columns = batch.columns(topic, tuple(channel.field for _, _, channel in entries))
                within = inside(columns.log, origin or 0, self._window)
                for i, (name, role, channel) in enumerate(entries):
                    present = columns.present[:, i] & (within if role == "displacement" else True)
                    value = channel.value(columns.values[present, i])
                    chunk.add(
                        name, role, Arrivals(columns.rank[present], columns.stamp[present], value), columns.log[present]
                    )
            yield chunk

    def check(self, samples: Mapping[str, int]) -> None:
        """Rejects dampers without a sample.

        Raises:
            InputError: if a damper has none.
        """
        for name, count in samples.items():
            if not count:
                channel = self._dampers[name].displacement
                raise InputError(
                    f"{self._bag.path}: topic {channel.topic} never has the field {channel.field} (damper {name}); "
                    "correct the signal map or choose another damper with -d"
                )


def part_chunk(part: Part, chosen: SignalMap, window: tuple[float, float]) -> Chunk:
    """All samples in memory, as they would arrive from the bag that `write_part` writes."""
    chunk = Chunk()
    within = inside(part.stamps, int(part.stamps[0]), window)
    for name, signals in chosen.dampers.items():
        wanted = {role: channel for role, channel in signals.channels().items() if role in roles(chosen)}
        for role, data in part_channels(part, name, wanted).items():
            chosen_samples = within if role == "displacement" else slice(None)
            arrivals = Arrivals(data.rank[chosen_samples], data.stamp[chosen_samples], data.value[chosen_samples])
            chunk.add(name, role, arrivals, data.stamp[chosen_samples])
    return chunk


def roles(chosen: SignalMap) -> tuple[str, ...]:
    """The channels that a line uses; the acceleration only if the map fuses it."""
    return ("displacement", "force", *SLOW, *(("acceleration",) if chosen.fusion else ()))


def inside(log: np.ndarray, origin: int, window: tuple[float, float]) -> np.ndarray:
    """(n,) bool: recorded within a window, s after the origin (ns)."""
    elapsed = (log - origin) * 1e-9
    return (elapsed >= window[0]) & (elapsed <= window[1])
