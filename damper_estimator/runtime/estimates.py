"""Estimates of one damper, under the names of damper_msgs/DamperForces."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.signals import Kinematics

FIELDS = (
    "displacement", "velocity", "acceleration", "force", "force_stddev", "force_min", "force_max",
    "dforce_dvelocity", "dforce_dcurrent",
)  # fmt: skip


@dataclass(frozen=True)
class Estimates:
    """Estimates for the good ones among the received samples.

    Attributes:
        kinematics: of the good samples, (n,).
        force: (n,) N; NaN if the model gave no finite number.
        published: (n,) N, the force; if that is not finite, the last finite one (0 before the first).
        stddev: (n,) N, the standard deviation of the fit's residual; NaN if the model was not fitted.
        status: (n,) uint8, the constants of damper_msgs/DamperForces.
        verdict: on each received sample (``signals.admission``).
        reach: (4, n), reachable forces and slopes, from force_min to dforce_dcurrent; None if the force depends on
            no command.
    """

    kinematics: Kinematics
    force: np.ndarray
    published: np.ndarray
    stddev: np.ndarray
    status: np.ndarray
    verdict: np.ndarray
    reach: np.ndarray | None = None

    def fields(self) -> dict[str, np.ndarray]:
        """The numeric fields of damper_msgs/DamperForces, each (n,); NaN means not available."""
        reach = np.full((4, self.force.size), np.nan) if self.reach is None else self.reach
        return {
            "displacement": self.kinematics.displacement,
            "velocity": self.kinematics.velocity,
            "acceleration": self.kinematics.acceleration,
            "force": self.published,
            "force_stddev": self.stddev,
            **dict(zip(FIELDS[5:], reach, strict=True)),
            "status": self.status,
        }
