"""The channels of a test that lies in memory, as they would be read from the recording that `write_part` makes."""

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
_STAMPED = ("temperature", "pressure", "acceleration")  # a command has no stamp but its time of arrival


def part_channels(part: Part, damper: str, channels: Mapping[str, Channel]) -> dict[str, ChannelData]:
    """The channels of one damper by role, in order of arrival; a number in place of an array holds for all samples.

    Args:
        channels: how each value is converted; topics and fields are not looked at.
    """
    found = {}
    for role, values in part.dampers[damper].items():
        if role not in channels:
            continue
        every = np.broadcast_to(np.asarray(values, float), part.stamps.shape)
        there = np.ones(every.shape, bool) if role in _FAST else np.isfinite(every)
        if not there.any():
            continue
        # Three messages at most belong to one sample: slow channels, displacement, force.
        place = _FAST.index(role) + 1 if role in _FAST else 0
        stamp = part.stamps if role in (*_FAST, *_STAMPED) else part.stamps - _AHEAD
        rank = 3 * np.arange(part.stamps.size, dtype=np.int64) + place
        found[role] = ChannelData(stamp[there], rank[there], channels[role].value(every[there]))
    return found
