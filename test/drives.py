"""Recordings of viscous dampers with friction, in memory and as bags, for the tests of the use cases and of the API."""

import numpy as np

from damper_estimator.recordings import BagWriter, Stream, floats, joint_states, temperatures

START = 1_700_000_000 * 10**9
RATE = 200
STATE = "sensor_msgs/msg/JointState"


def samples(seconds=6.0, seed=0, gain=1500.0):
    """Time (n,) s, displacement m, force N, temperature deg C."""
    time = np.arange(round(seconds * RATE)) / RATE
    draw = np.random.default_rng(seed)
    phases = draw.uniform(0.0, 6.0, 8)
    x = 0.01 * sum(np.sin(2 * np.pi * f * time + p) / f for f, p in zip(np.linspace(0.7, 6.0, 8), phases, strict=True))
    v = np.gradient(x, time)
    force = gain * v + 60.0 * np.tanh(v / 0.02) + 3.0 * draw.standard_normal(time.size)
    return time, x, force, 30.0 + 0.5 * time


def write_drive(path, dampers=("front_left",), force=True, seed=0, current=None, **more):
    """A bag of these dampers; ``current`` (n,) A of the first one. Returns its path."""
    time, *_ = samples(seed=seed, **more)
    every = [samples(seed=seed + k, **more) for k in range(len(dampers))]
    stamp = START + np.rint(time * 1e9).astype(np.int64)
    slow = stamp[::RATE]
    streams = [
        Stream(
            f"/suspension/{name}/temperature", "sensor_msgs/msg/Temperature", slow,
            temperatures(slow, drive[3][::RATE]),
        )
        for name, drive in zip(dampers, every, strict=True)
    ]  # fmt: skip
    if current is not None:
        streams.append(
            Stream(f"/suspension/{dampers[0]}/current", "std_msgs/msg/Float64", stamp - 1000, floats(current))
        )
    position = np.stack([drive[1] for drive in every], axis=1)
    streams.append(
        Stream("/suspension/displacement", STATE, stamp, joint_states(list(dampers), stamp, position=position))
    )
    if force:
        effort = np.stack([drive[2] for drive in every], axis=1)
        streams.append(Stream("/suspension/force", STATE, stamp, joint_states(list(dampers), stamp, effort=effort)))
    with BagWriter(path) as bag:
        bag.write_streams(streams)
    return path
