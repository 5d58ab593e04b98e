"""Recordings with known faults, made of shipped ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, SignalMap, measure

BAGS = Path(__file__).resolve().parents[2] / "bags"
DAMPER = "passenger_front"


def read(name: str) -> Measurement:
    """A shipped recording."""
    return measure(open_bag(BAGS / f"{name}.mcap"), SignalMap(), DAMPER)


def changed(measurement: Measurement, change) -> Measurement:
    """The measurement with something added to the force: ``change`` of its kinematics, (n,) N."""
    return replace(measurement, force=measurement.force + change(measurement.kinematics))


def halves(measurement: Measurement) -> tuple[Measurement, Measurement]:
    """Two parts: to fit to, and unseen."""
    middle = len(measurement.kinematics) // 2
    return measurement.part(0, middle), measurement.part(middle, len(measurement.kinematics))


def late(measurement: Measurement, seconds: float) -> Measurement:
    """The measurement with its force late by so much."""
    time = measurement.kinematics.time
    return replace(measurement, force=np.interp(time - seconds, time, measurement.force))
