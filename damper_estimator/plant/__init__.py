"""Simulated dampers from chamber pressures, valves and seals, never from the effects' equations; benches and sensors.

    drive = bench_drive("random", DAMPERS["passenger_front"], seconds=60.0, seed=1)
    truth = simulate(DAMPERS["passenger_front"], drive)       # noise-free force, pressures, temperature
    sensed = measure(truth, Sensors(), seed=1)                # the recording of a logger
    case = hidden(("friction",), Setup(damper, Sensors()), (base_drive, fit_drive, unseen_drive), 0.1, seed=1)

``phenomena`` lists what can be hidden and the meaning of its magnitude.
"""

from damper_estimator.plant.calibration import Calibration, calibrate, relative_difference, strength
from damper_estimator.plant.catalogue import DAMPERS
from damper_estimator.plant.damper import Damper
from damper_estimator.plant.excitation import BENCH_EXCITATIONS, bench_drive, current_steps
from damper_estimator.plant.hidden import Hidden, Record, hidden, record, switched, without
from damper_estimator.plant.phenomena import PHENOMENA, Phenomenon, Setup
from damper_estimator.plant.sensors import Channel, Sensed, Sensors, ideal_force, measure
from damper_estimator.plant.simulation import STEP, Drive, Truth, simulate

__all__ = [
    "BENCH_EXCITATIONS",
    "DAMPERS",
    "PHENOMENA",
    "STEP",
    "Calibration",
    "Channel",
    "Damper",
    "Drive",
    "Hidden",
    "Phenomenon",
    "Record",
    "Sensed",
    "Sensors",
    "Setup",
    "Truth",
    "bench_drive",
    "calibrate",
    "current_steps",
    "hidden",
    "ideal_force",
    "measure",
    "record",
    "relative_difference",
    "simulate",
    "strength",
    "switched",
    "without",
]
