"""The errors to expect on a test, of sensors and of the model's form, estimated from the recordings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis import Explanations
from damper_estimator.effects.trial import Ranges
from damper_estimator.numerics import long_run_variance
from damper_estimator.planning.simulated import Simulated
from damper_estimator.planning.steps import Step

_LEAST_FORM = 0.01  # of the force: what no model's form gets right
_AT_REST = 0.1  # of the force's mean square on the recordings


@dataclass(frozen=True)
class Errors:
    """Errors to expect, estimated from the recordings.

    Attributes:
        noise: N^2 of a row, of the sensors.
        form: squared error of the model's form over the force's mean square.
        memory: rows after which the error is new.
        power: N^2, mean square of the force on the recordings.
    """

    noise: float
    form: float
    memory: float
    power: float

    def alike(self, rows: np.ndarray, steps: Sequence[Step]) -> np.ndarray:
        """(s,) rows of each step, of the given number, in which the form errs alike."""
        return np.clip(self.memory * np.array([step.cycles for step in steps]), 1.0, np.maximum(rows, 1))

    def powers(self, on: Simulated, ranges: Ranges) -> np.ndarray:
        """(h, s) N^2 over which the form errs on each step: the variance of the force, and a share of that on the
        recordings at least, since a model is not perfect at rest either. Both grow with the square of the distance
        beyond the recorded strokes and speeds, where the model was not compared and stops may be.
        """
        kinematics, picks = on.rows.measurement.kinematics, on.rows.picks
        away = np.abs(kinematics.displacement[picks] - ranges.middle) / (0.5 * ranges.stroke)
        beyond = np.maximum(away, np.abs(kinematics.velocity[picks]) / ranges.speed)
        found = np.zeros((len(on.force), on.largest.size))
        for k, part in enumerate(on.slices):
            if part.stop > part.start:
                least = np.maximum(on.force[:, part].var(axis=1), _AT_REST * self.power)
                found[:, k] = least * max(1.0, float(beyond[part].max())) ** 2
        return found


def errors_of(found: Explanations, floor_n: float) -> Errors:
    """From what the best hypothesis leaves on the recordings, and their noise floor in N."""
    best = min(found.fitted, key=lambda hypothesis: float(np.sum(hypothesis.residual**2)))
    target = np.concatenate([part.target for part in found.rows])
    left, power = float(np.mean(best.residual**2)), max(float(np.mean(target**2)), 1e-300)
    noise = min(floor_n**2, left) if np.isfinite(floor_n) else 0.5 * left
    memory = long_run_variance(best.residual, found.rows[0].rate) / max(left, 1e-300)
    return Errors(noise, max((left - noise) / power, _LEAST_FORM**2), max(memory, 1.0), power)
