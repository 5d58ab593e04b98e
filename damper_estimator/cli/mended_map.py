"""The signal map that ``improve`` writes: the one that was used, with the mended dampers in it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from damper_estimator.recordings import open_bag
from damper_estimator.signals import DamperSignals, SignalMap
from damper_estimator.signals.channels import signals_for


def mended_map(used: SignalMap, bags: Sequence[Path], mended: Mapping[str, DamperSignals]) -> SignalMap:
    """The map for these recordings with some dampers' entries replaced; it names every damper that is in them."""
    dampers: dict[str, DamperSignals] = {}
    for path in bags:
        with open_bag(path) as bag:
            dampers = {**signals_for(bag, used).dampers, **dampers}
    whole = replace(used, dampers=dampers)
    for damper, own in mended.items():
        whole = whole.with_entry(damper, own)
    return whole
