"""The channels of a test in memory, as if read from the recording that `write_part` writes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.signals.channels import ChannelData
from damper_estimator.signals.signal_map import Channel

if TYPE_CHECKING:  # the node runs without the readers' libraries
    from damper_estimator.recordings import Part

_FAST = ("displacement", "force")
_AHEAD = 1_000  # ns; a slow channel arrives before the sample that it belongs to
_STAMPED = ("temperature", "pressure", "acceleration")  # a command has only its time of arrival


def part_channels(part: Part, damper: str, channels: Mapping[str, Channel]) -> dict[str, ChannelData]:
    """The channels of one damper by role, in order of arrival; a number instead of an array applies to all samples.

    Args:
        channels: conversion of each value; topics and fields are ignored.
    """
    found = {}
    for role, values in part.dampers[damper].items():
        if role not in channels:
            continue
        every = np.broadcast_to(np.asarray(values, float), part.stamps.shape)
        present = np.ones(every.shape, bool) if role in _FAST else np.isfinite(every)
        if not present.any():
            continue
        # Three messages at most belong to one sample: slow channels, displacement, force.
        place = _FAST.index(role) + 1 if role in _FAST else 0
        stamp = part.stamps if role in (*_FAST, *_STAMPED) else part.stamps - _AHEAD
        rank = 3 * np.arange(part.stamps.size, dtype=np.int64) + place
        found[role] = ChannelData(stamp[present], rank[present], channels[role].value(every[present]))
    return found
