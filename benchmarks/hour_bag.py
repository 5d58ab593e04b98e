"""A recording of the length of a test drive: one hour at 1 kHz, four dampers in one message (14.4 million samples)."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from damper_estimator.plant import DAMPERS, Sensors, measure, simulate
from damper_estimator.recordings import BagWriter, Stream, joint_states
from damper_estimator.vehicle import drive
from damper_estimator.workflows.simulated_bags import DISPLACEMENT, EPOCH, FORCE

CORNERS = ("front_left", "front_right", "rear_left", "rear_right")
_PIECE = 20.0  # s, simulated part; it begins and ends at rest, so it can be repeated


def write_hour(path: Path, seconds: float = 3600.0, rate: float = 1000.0, seed: int = 7) -> None:
    """Writes the recording, ``seconds`` long: a road of 20 s repeated, each time with different noise."""
    count = round(_PIECE * rate)
    sensors = Sensors(rate=rate, drop_out=0.0)
    pieces = []
    for number in range(len(CORNERS)):
        damper = replace(DAMPERS["passenger_front"], name="passenger_front")
        truth = simulate(damper, drive("road", damper, _PIECE + 0.5, seed + number))
        sensed = measure(truth, sensors, seed + number, clock_seed=seed)
        pieces.append((sensed.true_displacement.value[:count], sensed.true_force.value[:count]))
    motion, force = (np.stack(columns, axis=1) for columns in zip(*pieces, strict=True))
    draw = np.random.default_rng(seed)
    with BagWriter(path) as bag:
        for turn in range(round(seconds / _PIECE)):
            stamp = EPOCH + np.round((turn * _PIECE + np.arange(count) / rate) * 1e9).astype(np.int64)
            x = motion + sensors.displacement_noise * draw.standard_normal(motion.shape)
            f = force + sensors.force_noise * draw.standard_normal(force.shape)
            bag.write_streams([
                Stream(DISPLACEMENT, "sensor_msgs/msg/JointState", stamp, joint_states(CORNERS, stamp, position=x)),
                Stream(FORCE, "sensor_msgs/msg/JointState", stamp, joint_states(CORNERS, stamp, effort=f)),
            ])  # fmt: skip
