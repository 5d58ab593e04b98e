"""Recordings with known faults, made of shipped ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from damper_estimator.model import DamperModel
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


def wandering(measurement: Measurement, rms: float, bandwidth: float = 15.0) -> Measurement:
    """The measurement with an error that follows nothing: ``rms`` in N, up to ``bandwidth`` in Hz."""
    time = measurement.kinematics.time
    spectrum = np.fft.rfft(np.random.default_rng(0).standard_normal(time.size))
    spectrum[np.fft.rfftfreq(time.size, time[1] - time[0]) > bandwidth] = 0.0
    error = np.fft.irfft(spectrum, time.size)
    return replace(measurement, force=measurement.force + rms * error / error.std())


def erring(model: DamperModel, newtons: float) -> DamperModel:
    """The model as if it had erred by so much when it was identified, in a way that it has no record of."""
    return replace(model, fit={**model.fit, "residual_stddev": newtons, "misfit": {}})
