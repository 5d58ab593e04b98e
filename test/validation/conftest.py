"""Measurements made of functions of time, without a bag; and recordings of simulated dampers, with one."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.plant import DAMPERS, Sensors, Truth, current_steps, simulate
from damper_estimator.plant import measure as sense
from damper_estimator.recordings import BagWriter, floats, joint_states, open_bag
from damper_estimator.signals import Counts, Measurement, SignalMap, default_signals, low_pass, measure
from damper_estimator.signals.kinematics import Differentiator
from damper_estimator.vehicle import drive

DAMPING = 1500.0  # N s/m, of the model that the tests run


@pytest.fixture(scope="session")
def viscous() -> DamperModel:
    """F = 1500 N s/m v."""
    element = make_element(find_effect("linear_viscous"), {"rebound": DAMPING, "compression": DAMPING})
    return DamperModel("viscous", "", (element,))


@pytest.fixture(scope="session")
def motion():
    """Random-like displacement (n,) m, even energy from 0.3 to 12 Hz, and its time (n,) s."""

    def make(seconds=40.0, rate=500.0, seed=0, rms=0.01):
        time = np.arange(round(seconds * rate)) / rate
        draw = np.random.default_rng(seed)
        frequency = np.linspace(0.3, 12.0, 40)
        waves = np.sin(2 * np.pi * frequency * time[:, None] + draw.uniform(0, 2 * np.pi, 40)) / frequency**1.5
        x = waves.sum(axis=1)
        return time, rms * x / x.std()

    return make


@pytest.fixture(scope="session")
def measured():
    """Measurement of a displacement and of the force that a function of (kinematics, force before) makes of it.

    ``of`` takes the kinematics and returns the measured damper force (n,) as it would be behind the causal filter.
    ``gauge`` is the raw gauge; ``raw`` the displacement as the model sees it.
    """

    def make(time, displacement, of, gauge=None, cutoff=60.0, band=30.0, max_gap=0.1, **slow):
        stamp = np.round(time * 1e9).astype(np.int64)
        kinematics, verdict = Differentiator(cutoff, max_gap).block(stamp, displacement, **slow)
        force = of(kinematics)
        return Measurement(
            recording="made.mcap",
            damper="front_left",
            kinematics=kinematics,
            force=force,
            judged=kinematics.warm(),
            counts=Counts.of(verdict),
            gauge=force if gauge is None else gauge,
            raw_displacement=displacement,
            cutoff=cutoff,
            band=band,
            signals=default_signals("front_left"),
        )

    return make


@pytest.fixture(scope="session")
def filtered():
    """A signal through the causal filter at 60 Hz, as the measured force is: (kinematics, values) to values."""
    return lambda kinematics, values, cutoff=60.0: low_pass(cutoff, kinematics.dt, values)


@cache
def driven(damper: str, excitation: str, seed: int, seconds: float = 20.0) -> Truth:
    """A simulated damper on its way, without sensors; an adjustable one with steps of its current."""
    plant = DAMPERS[damper]
    current = current_steps(seconds, seed) if plant.coil.pressure > 0.0 else None
    return simulate(plant, drive(excitation, plant, seconds, seed, current))


@pytest.fixture(scope="session")
def truth_of():
    """The noise-free record of a simulated damper, by damper, excitation and seed."""
    return driven


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """Measurement of a simulated damper, through a bag.

    ``change`` gets the channels by role and returns them as the logger wrote them; the rest are fields of ``Sensors``.
    """
    folder, count = tmp_path_factory.mktemp("recorded"), iter(range(10**6))

    def make(damper="passenger_front", excitation="random", seed=1, change=None, signal_map=None, **sensors):
        truth = driven(damper, excitation, seed)
        sensed = sense(truth, replace(Sensors(), **sensors), seed)
        channels = {"displacement": sensed.displacement, "force": sensed.force, "current": sensed.current}
        channels = change(channels) if change else channels
        path = folder / f"{next(count)}.mcap"
        with BagWriter(path) as bag:
            for role, field in (("displacement", "position"), ("force", "effort")):
                channel = channels[role]
                messages = joint_states([damper], channel.stamp, **{field: channel.value[:, None]})
                bag.write_messages(f"/suspension/{role}", "sensor_msgs/msg/JointState", channel.stamp, messages)
            if DAMPERS[damper].coil.pressure > 0.0:
                channel = channels["current"]
                topic = f"/suspension/{damper}/current"
                bag.write_messages(topic, "std_msgs/msg/Float64", channel.stamp, floats(channel.value))
        with open_bag(path) as bag:
            return measure(bag, signal_map or SignalMap(), damper)

    return make
