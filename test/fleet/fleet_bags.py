"""Small recordings for the tests of the fleet, and functions that workers execute in them."""

import json
import os
import signal
from errno import ENOSPC
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings import BagWriter, Stream, joint_states, temperatures

START = 1_700_000_000 * 10**9
DAY = 86400 * 10**9
RATE = 200


def write_drive(path, seed=0, dampers=("front_left",), gain=1500.0, warm=30.0, begin=START, seconds=6.0, scale=1.0):
    """A bag of displacements, multiplied by ``scale``, forces of a viscous damper with friction, and a temperature."""
    time = np.arange(round(seconds * RATE)) / RATE
    draw = np.random.default_rng(seed)
    phases = draw.uniform(0, 6, (len(dampers), 8))
    waves = [
        sum(np.sin(2 * np.pi * f * time + p) / f for f, p in zip(np.linspace(0.7, 6.0, 8), damper_phases, strict=True))
        for damper_phases in phases
    ]
    x = 0.01 * np.stack(waves, axis=1)
    v = np.gradient(x, time, axis=0)
    force = gain * v + 60.0 * np.tanh(v / 0.02) + 3.0 * draw.standard_normal(x.shape)
    stamp = begin + np.round(time * 1e9).astype(np.int64)
    slow = stamp[::RATE]
    path.parent.mkdir(parents=True, exist_ok=True)
    names, state = list(dampers), "sensor_msgs/msg/JointState"
    streams = [
        Stream("/suspension/displacement", state, stamp, joint_states(names, stamp, position=scale * x)),
        Stream("/suspension/force", state, stamp, joint_states(names, stamp, effort=force)),
    ] + [
        Stream(
            f"/suspension/{name}/temperature",
            "sensor_msgs/msg/Temperature",
            slow,
            temperatures(slow, np.full(slow.size, warm)),
        )
        for name in names
    ]
    with BagWriter(path) as bag:
        bag.write_streams(streams)
    return path


def attempts(task, note=""):
    """How often a task was started: one line for each in a file next to its results."""
    path = Path(task.folder) / f"{task.damper}.attempts"
    with path.open("a") as file:
        file.write(f"{note or os.getpid()}\n")
    return len(path.read_text().splitlines())


def quick(task):
    """Counts its calls and does nothing else."""
    attempts(task)
    task.place("json").write_text(json.dumps({"damper": task.damper}))
    return {"rmse_n": float(len(task.recording)), "samples": 1}


def dies_once(task):
    """Kills its worker the first time that it gets a recording of this name."""
    if "deadly" in Path(task.recording).name and attempts(task) == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(task)


def dies_four_times(task):
    """Kills its worker at a recording of this name, once more than Dask tolerates."""
    if "unlucky" in Path(task.recording).name and attempts(task) <= 4:
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(task)


def dies_always(task):
    """Kills its worker whenever it gets a recording of this name."""
    if "deadly" in Path(task.recording).name:
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(task)


def fills_the_disk(task):
    """Fails because the disk is full."""
    if "large" in Path(task.recording).name:
        try:
            raise OSError(ENOSPC, os.strerror(ENOSPC), str(task.place("json")))
        except OSError as error:
            raise InputError(f"{task.place('json')}: cannot be written; choose another place with -o") from error
    return quick(task)


def has_a_bug(task):
    """Raises an unexpected exception for one recording."""
    if "odd" in Path(task.recording).name:
        raise ZeroDivisionError("in\nour code")
    return quick(task)
