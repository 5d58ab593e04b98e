"""Force of a slow test over displacement and direction, to be subtracted from other tests (gas, spring, dry friction).

    F_s(x, v) = w F_rebound(x) + (1 - w) F_compression(x),      w = (1 + clip(v / v_s, -1, 1)) / 2

with v_s the slow test's own speed, so that the force does not jump between the two curves at standstill.
Source: HIS paper, section 2.2 and figure 4 (5 mm/s).
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.signals import Measurement

SLOW = 0.2  # speed of the slow test over that of the others, at most
_BINS = 80
_FEWEST = 5  # samples in a bin


@dataclass(frozen=True)
class QuasiStatic:
    """The force of a slow test.

    Attributes:
        recording: the slow test's bag.
        displacement: (k,) m, rising.
        rebound, compression: (k,) N at these displacements by direction of motion.
        speed: m/s, of the slow test.
    """

    recording: str
    displacement: np.ndarray
    rebound: np.ndarray
    compression: np.ndarray
    speed: float

    def force(self, displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """N, (n,); beyond the slow test's stroke the value at its end."""
        share = 0.5 * (1.0 + np.clip(velocity / self.speed, -1.0, 1.0))
        up = np.interp(displacement, self.displacement, self.rebound)
        down = np.interp(displacement, self.displacement, self.compression)
        return share * up + (1.0 - share) * down

    def outside(self, displacement: np.ndarray) -> float:
        """Share of displacements (n,) beyond the slow test's stroke."""
        return float(np.mean((displacement < self.displacement[0]) | (displacement > self.displacement[-1])))

    def remaining(self, measurement: Measurement) -> np.ndarray:
        """A measured force (n,) minus the quasi-static one.

        Raises:
            InputError: if the test was not slow compared with this measurement.
        """
        kinematics = measurement.kinematics
        speed = float(np.quantile(np.abs(kinematics.velocity), 0.99))
        if self.speed > SLOW * speed:
            raise InputError(
                f"{self.recording}: moves at {self.speed:.3g} m/s, which is not slow compared with {speed:.3g} m/s of "
                f"{measurement.recording}; drive a quasi-static test at about 0.005 m/s"
            )
        return measurement.force - self.force(kinematics.displacement, kinematics.velocity)


def quasi_static(slow: Measurement) -> QuasiStatic:
    """Mean force over displacement of a slow test, for each direction; reversals are left out.

    Raises:
        InputError: if one of the directions is missing.
    """
    kinematics, judged = slow.kinematics, slow.judged
    moving = np.abs(kinematics.velocity)[judged]
    speed = float(np.quantile(moving, 0.8)) if moving.size else 0.0
    curves = []
    for sign in (1.0, -1.0):
        inside = judged & (sign * kinematics.velocity > 0.5 * speed)
        if np.count_nonzero(inside) < 2 * _FEWEST or speed <= 0.0:
            raise InputError(
                f"{slow.recording}: does not move in both directions; drive a quasi-static test as a slow "
                "sine or triangle"
            )
        curves.append(_curve(kinematics.displacement[inside], slow.force[inside]))
    (x_up, up), (x_down, down) = curves
    x = np.linspace(min(x_up[0], x_down[0]), max(x_up[-1], x_down[-1]), _BINS)
    return QuasiStatic(slow.recording, x, np.interp(x, x_up, up), np.interp(x, x_down, down), speed)


def _curve(x: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means over even bins of displacement; bins with few samples are left out."""
    edges = np.linspace(x.min(), x.max(), _BINS + 1)
    place = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, _BINS - 1)
    count = np.bincount(place, minlength=_BINS)
    full = count >= min(_FEWEST, int(count.max()))
    mean_x, mean_force = (np.bincount(place, values, _BINS)[full] / count[full] for values in (x, force))
    return mean_x, mean_force
