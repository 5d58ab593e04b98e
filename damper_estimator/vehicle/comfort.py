"""The comfort simulation: a car on four posts in phase, swept at several amplitudes, with any damper models.

Source: Gao et al., section 5 (0.5 to 6 Hz; several amplitudes, as it is not published: from a suspension locked by
friction to working valves).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.vehicle.four_posts import (
    FORCE,
    STEP,
    TRAVEL,
    VELOCITY,
    Transfer,
    four_posts,
    on_posts,
    sweep,
    transfer,
)
from damper_estimator.vehicle.full_car import FullCar

AMPLITUDES = (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.04)
"""m, of the posts."""

AXLES = ("front", "rear")


@dataclass(frozen=True)
class Loops:
    """A left damper in a part of the sweep: travel (m), velocity (m/s) and force (N, less that at rest), (n,)."""

    travel: np.ndarray
    velocity: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class ComfortRun:
    """One model at one amplitude (m): transfer functions and dampers, by axle; ``begin`` is the first third."""

    amplitude: float
    transfer: Mapping[str, Transfer]
    begin: Mapping[str, Loops]
    rest: Mapping[str, Loops]


def comfort_run(
    car: FullCar,
    models: Mapping[str, DamperModel],
    amplitude: float,
    band: tuple[float, float] = (0.5, 6.0),
    seconds: float = 60.0,
    step: float = STEP,
) -> ComfortRun:
    """Sweeps the posts through ``band`` (Hz) in ``seconds`` at one amplitude (m); ``models`` by axle."""
    height = sweep(amplitude, *band, seconds, step=step)
    run = on_posts(car, models, four_posts(height), step)
    third = round(seconds / 3.0 / step)
    thin = max(1, round(2e-3 / step))
    transfers, begins, rests = {}, {}, {}
    for axle, wheel in zip(AXLES, (0, 2), strict=True):
        transfers[axle] = transfer(height, run.over_axle(axle == "front"), step, *band)
        for store, part in ((begins, slice(0, third, thin)), (rests, slice(third, round(seconds / step), thin))):
            damper = run.damper[:, wheel, part]
            store[axle] = Loops(damper[TRAVEL], damper[VELOCITY], damper[FORCE])
    return ComfortRun(amplitude, transfers, begins, rests)


def transfer_difference(one: Transfer, other: Transfer) -> float:
    """RMS over frequency of the complex difference, over that of ``other``; 1."""
    return float(np.sqrt(np.mean(np.abs(one.value - other.value) ** 2) / np.mean(np.abs(other.value) ** 2)))


def resonance(found: Transfer) -> tuple[float, float]:
    """Frequency (Hz) and size (1) of the largest amplification."""
    peak = int(np.argmax(np.abs(found.value)))
    return float(found.frequency[peak]), float(np.abs(found.value[peak]))


def differences(runs: Sequence[ComfortRun], others: Sequence[ComfortRun]) -> dict[str, list[float]]:
    """`transfer_difference` of two models over the amplitudes, by axle."""
    return {
        axle: [transfer_difference(a.transfer[axle], b.transfer[axle]) for a, b in zip(runs, others, strict=True)]
        for axle in AXLES
    }
