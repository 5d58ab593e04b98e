"""Reads the channels of a signal map from a bag, in one pass over the file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.signals.signal_map import Channel, SignalMap, default_signals

if TYPE_CHECKING:  # the node runs without the readers' libraries
    from damper_estimator.recordings import Bag


@dataclass(frozen=True)
class ChannelData:
    """The values of one channel in order of arrival.

    Attributes:
        stamp: (n,) int64 ns, the message's stamp (its time of arrival if it has none).
        rank: (n,) int64, position among all messages of the bag.
        value: (n,) SI.
    """

    stamp: np.ndarray
    rank: np.ndarray
    value: np.ndarray


def find_topic(bag: Bag, topic: str) -> str | None:
    """The bag's name for a topic: with or without the leading slash, or the only one that ends with the topic."""
    names = [t.name for t in bag.topics]
    bare = topic.lstrip("/")
    exact = [name for name in names if name.lstrip("/") == bare]
    inside_namespace = [name for name in names if name.endswith(f"/{bare}")] if not topic.startswith("/") else []
    matches = exact or inside_namespace
    return matches[0] if len(matches) == 1 else None


def damper_names(bag: Bag) -> list[str]:
    """Names in the messages on the default displacement topic, in order of appearance.

    Raises:
        InputError: if the bag has no such topic, or it has no names.
    """
    default = default_signals("").displacement.topic
    topic = find_topic(bag, default)
    if topic is None:
        existing = ", ".join(f"{t.name} ({t.type})" for t in bag.topics) or "none"
        raise InputError(
            f"{bag.path}: has no topic {default}; it has {existing}; name the right one in a signal map "
            "(damper-estimator inspect proposes one)"
        )
    names: dict[str, None] = {}
    for batch in bag.batches([topic], size=100):
        for _, message in batch.messages(topic):
            names |= dict.fromkeys(getattr(message, "name", ()))
        break
    if not names:
        raise InputError(f"{bag.path}: the messages on {topic} name no damper; write a signal map")
    return list(names)


def signals_for(bag: Bag, signal_map: SignalMap, damper: str | None = None) -> SignalMap:
    """The map with named dampers, from the bag if the map names none; only ``damper`` if that is given.

    Raises:
        InputError: if the damper is unknown.
    """
    full = signal_map if signal_map.dampers else signal_map.with_dampers(damper_names(bag))
    if damper is None:
        return full
    if damper not in full.dampers:
        where = signal_map.where if signal_map.dampers else bag.path
        raise InputError(f"{where}: has no damper {damper!r}; it has {', '.join(full.dampers)}")
    return replace(full, dampers={damper: full.dampers[damper]})


def read_channels(bag: Bag, channels: Mapping[str, Channel], ends: bool = False) -> dict[str, ChannelData]:
    """The channels in the bag, by the same keys, in one pass over the bag, or only over its ``ends``.

    Raises:
        InputError: if a channel that a map names is missing, or its field never appears.
    """
    found = {key: find_topic(bag, channel.topic) for key, channel in channels.items()}
    for key, topic in found.items():
        if topic is None and channels[key].given:
            existing = ", ".join(t.name for t in bag.topics)
            raise InputError(
                f"{bag.path}: has no topic {channels[key].topic} ({key}); it has {existing}; correct the signal map"
            )
    keys_by_topic: dict[str, list[str]] = {}
    for key, topic in found.items():
        if topic is not None:
            keys_by_topic.setdefault(topic, []).append(key)
    parts: dict[str, list[ChannelData]] = {key: [] for keys in keys_by_topic.values() for key in keys}
    for batch in bag.batches(list(keys_by_topic), ends=ends) if keys_by_topic else ():
        for topic, keys in keys_by_topic.items():
            columns = batch.columns(topic, tuple(channels[key].field for key in keys))
            for i, key in enumerate(keys):
                present = columns.present[:, i]
                value = channels[key].value(columns.values[present, i])
                parts[key].append(ChannelData(columns.stamp[present], columns.rank[present], value))
    data = {key: _joined(of_key) for key, of_key in parts.items() if of_key}
    for key, channel in channels.items():
        if key in parts and (key not in data or data[key].stamp.size == 0) and channel.given:
            raise InputError(
                f"{bag.path}: topic {found[key]} never has the field {channel.field} ({key}); correct the signal map"
            )
    return {key: channel_data for key, channel_data in data.items() if channel_data.stamp.size}


def _joined(parts: list[ChannelData]) -> ChannelData:
    return ChannelData(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("stamp", "rank", "value")))


def too_few(recording: str, damper: str, count: int, arrived: ChannelData, start: float, end: float) -> InputError:
    """The error where a recording has no samples from ``start`` to ``end`` in s, or only one with a later stamp."""
    if count:
        return InputError(
            f"{recording}: only one of {arrived.stamp.size} displacement samples of damper {damper!r} can be used, as "
            "no stamp is later than the first; let the driver stamp every sample"
        )
    return InputError(
        f"{recording}: no samples of damper {damper!r} from {start:g} to {end:g} s; widen --from, --to or the map's "
        "windows"
    )
