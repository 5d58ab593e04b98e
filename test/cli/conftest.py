"""Recordings and models that the tests of the verbs write in their own folders."""

import numpy as np
import pytest

from damper_estimator.recordings import BagWriter, floats, joint_states, temperatures

JOINT_STATE = "sensor_msgs/msg/JointState"
START = 1_700_000_000 * 10**9
MODEL = """\
name: viscous_and_friction
source: made for a test
effects:
  - linear_viscous: {rebound: 1500.0, compression: 1200.0}
  - tanh_hysteresis: {}
fit:
  residual_stddev: 20.0
  region: {velocity: [-5.0, 5.0]}
"""


@pytest.fixture
def model_file(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL)
    return path


@pytest.fixture
def write_bag(tmp_path):
    """Writes a bag of displacement, force (both JointState) and, if given, temperatures.

    ``names`` in the messages, ``stamp`` (n,) ns, ``displacement`` and ``force`` (n, k) or None; ``log`` defaults to
    the stamps.
    """

    def make(name, names, stamp, displacement, force=None, log=None, temperature=None, prefix="/suspension"):
        path = tmp_path / name
        log = stamp if log is None else log
        with BagWriter(path) as writer:
            writer.write_messages(
                f"{prefix}/displacement", JOINT_STATE, log, joint_states(names, stamp, position=displacement)
            )
            if force is not None:
                writer.write_messages(
                    f"{prefix}/force", JOINT_STATE, log + 1000, joint_states(names, stamp, effort=force)
                )
            for damper, (own_log, celsius) in (temperature or {}).items():
                messages = temperatures(own_log, celsius)
                writer.write_messages(
                    f"{prefix}/{damper}/temperature", "sensor_msgs/msg/Temperature", own_log, messages
                )
        return path

    return make


@pytest.fixture
def driven(write_bag):
    """A bag of two dampers at 500 Hz: stamps, displacements and the force of a viscous damper with an error."""

    def make(
        name="drive.mcap",
        seconds=8.0,
        seed=0,
        rest=0.0,
        names=("front_left", "front_right"),
        force=True,
        scale=1.0,
        **more,
    ):
        time = np.arange(round(seconds * 500)) / 500.0
        draw = np.random.default_rng(seed)
        moving = np.clip(time - rest, 0.0, 1.0) if rest else np.ones_like(time)
        waves = [np.sin(2 * np.pi * f * time + draw.uniform(0, 6)) / f for f in np.linspace(0.5, 9.0, 12)]
        x = np.stack([0.01 * moving * np.roll(np.sum(waves, axis=0), 40 * k) for k in range(len(names))], axis=1)
        v = np.gradient(x, time, axis=0)
        measured = 1500.0 * v + 200.0 * (v > 0.05) + 3.0 * draw.standard_normal(x.shape)
        stamp = START + np.round(time * 1e9).astype(np.int64)
        x = x + 1e-6 * draw.standard_normal(x.shape)
        path = write_bag(name, list(names), stamp, scale * x, measured if force else None, **more)
        return path, stamp, scale * x, measured

    return make


@pytest.fixture
def write_current(tmp_path):
    """Adds Float64 currents to a copy of a bag."""
    from damper_estimator.recordings import open_bag

    def make(source, name, topic, log, value):
        path = tmp_path / name
        with open_bag(source) as bag, BagWriter(path) as writer:
            for batch in bag.batches():
                writer.write_batch(batch)
            writer.write_messages(topic, "std_msgs/msg/Float64", log, floats(value))
        return path

    return make


@pytest.fixture
def refused(capsys):
    """Runs the command line; returns the one line on standard error after checking that the exit status is 1."""
    from damper_estimator.cli.main import main

    def run(*words):
        assert main([str(word) for word in words]) == 1
        lines = capsys.readouterr().err.strip().splitlines()
        assert len(lines) == 1 and "Traceback" not in lines[0]
        return lines[0]

    return run
