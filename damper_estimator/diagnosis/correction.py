"""Corrects mistakes of the measurement chain: in the signal map, and in what was measured with the old one."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from damper_estimator.model import Element
from damper_estimator.signals import Measurement
from damper_estimator.signals.signal_map import DamperSignals


def corrected_signals(signals: DamperSignals, element: Element) -> DamperSignals:
    """The damper's entry of the signal map, with what a channel effect says changed."""
    old = chain_of(signals)
    new = {**old, **element.effect.correct(element.parameters, old)}
    force = replace(signals.force, scale=new["scale"], offset=new["offset"], skew=new["skew"])
    return replace(signals, force=force, spring_rate=new["spring_rate"], preload=new["preload"])


def chain_of(signals: DamperSignals) -> dict[str, float]:
    """The numbers that turn the gauge's raw value into the damper's force."""
    force = signals.force
    return {
        "scale": force.scale,
        "offset": force.offset,
        "skew": force.skew,
        "spring_rate": signals.spring_rate,
        "preload": signals.preload,
    }


def corrected(measurement: Measurement, signals: DamperSignals) -> Measurement:
    """What would have been measured with another entry of the signal map.

    The filter is linear and the same before and after, so the filtered force can be turned over directly.
    """
    old, new = chain_of(measurement.signals), chain_of(signals)
    if old == new or measurement.force is None:
        return replace(measurement, signals=signals)
    x = measurement.kinematics.displacement
    gauge = measurement.force + old["spring_rate"] * x + old["preload"]
    gauge = _moved(measurement, gauge, new["skew"] - old["skew"])
    if old["scale"]:
        gauge = (gauge - old["offset"]) * (new["scale"] / old["scale"]) + new["offset"]
    return replace(measurement, force=gauge - new["spring_rate"] * x - new["preload"], signals=signals)


def _moved(measurement: Measurement, values: np.ndarray, lead: float) -> np.ndarray:
    """Values (n,) read ``lead`` seconds later, within each stretch."""
    if not lead:
        return values
    moved = np.empty_like(values)
    for part in measurement.kinematics.stretches():
        time = measurement.kinematics.time[part]
        moved[part] = np.interp(time + lead, time, values[part])
    return moved


def in_yaml(signals: DamperSignals, before: DamperSignals) -> Mapping[str, float]:
    """What changed, as the keys of the force's entry in a signal map."""
    old, new = chain_of(before), chain_of(signals)
    return {name: value for name, value in new.items() if value != old[name]}
