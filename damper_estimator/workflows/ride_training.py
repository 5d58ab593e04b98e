"""Training for ``ride``: a model and a look-up table from recordings of a simulated damper with stepped currents."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper_estimator.control import CurrentTable, table_from_samples
from damper_estimator.identification import fit
from damper_estimator.model import DamperModel
from damper_estimator.plant import Sensors, Setup, current_steps, record
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, T, V
from damper_estimator.vehicle import LIMITS, Corner, drive
from damper_estimator.workflows.cases import Progress
from damper_estimator.workflows.reading import read
from damper_estimator.workflows.simulated_bags import write_record

EXCITATIONS = ("random10", "road_c", "road_d")
TRAINING_SHARE = 0.4
"""Of the time that one damper takes."""

SETTLED = 0.1
"""s after a step of the current during which samples are excluded from the table."""


@dataclass(frozen=True)
class Trained:
    """A model and a table of one damper from the same recordings; ``rmse_n`` is the model's error on them."""

    model: DamperModel
    table: CurrentTable
    rmse_n: float


def train(
    name: str, corner: Corner, start: DamperModel, folder: Path, seconds: float, seed: int, progress: Progress
) -> Trained:
    """Records the damper on the bench and in its corner, identifies ``start`` and fits a table to the same samples."""
    measured = []
    for k, kind in enumerate(EXCITATIONS):
        progress(f"recording {kind}", 0.2 * k * TRAINING_SHARE)
        measured.append(recorded(name, corner, kind, folder, seconds, seed + k))
    progress(f"identifying {start.name}", 0.6 * TRAINING_SHARE)
    found = fit(start, measured, seed=seed)
    return Trained(found.model, _table(measured), found.rmse_n)


def recorded(name: str, corner: Corner, kind: str, folder: Path, seconds: float, seed: int) -> Measurement:
    """A recording of a drive with stepped currents as a logger writes it, read back as usual.

    Args:
        kind: among ``vehicle.EXCITATIONS``.
        folder: receives the bag.
    """
    motion = drive(kind, corner.damper, seconds, seed, current_steps(seconds, seed, highest=LIMITS[1]), corner.car)
    path = folder / f"{name}_{kind}.mcap"
    write_record(path, {name: record(Setup(corner.damper, Sensors()), motion, seed)}, with_current=True)
    (measured,) = read(path, dampers=name).with_force("ride").measurements[name]
    return measured


def _table(measured: list[Measurement]) -> CurrentTable:
    parts = []
    for measurement in measured:
        block, force = measurement.kinematics.block, np.asarray(measurement.force)
        changed = np.concatenate([[True], np.diff(block[COMMAND]) != 0.0])
        since = block[T] - np.maximum.accumulate(np.where(changed, block[T], -np.inf))
        good = measurement.judged & (since > SETTLED)
        parts.append(np.stack([block[V], block[COMMAND], force])[:, good])
    return table_from_samples(*np.concatenate(parts, axis=1))
