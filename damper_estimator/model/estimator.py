"""The live line of one damper: stamp and raw displacement in, estimate out. Node and ``replay`` run this same code."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.signals.kinematics import WARM_UP, Differentiator, Kinematics
from damper_estimator.signals.layout import COMMAND, TEMPERATURE, A, V, X

GOOD, WARMING_UP, EXTRAPOLATING, DEGRADED, STALE = range(5)
# Rows of the block by the name under which a fit records its region of validity.
REGION_ROWS = {"displacement": X, "velocity": V, "acceleration": A, "command": COMMAND, "temperature": TEMPERATURE}


@dataclass(frozen=True)
class Estimates:
    """Estimates for the good ones among the samples that came.

    Attributes:
        kinematics: of the good samples, (n,).
        force: (n,) N; NaN where the model gave no finite number.
        stddev: (n,) N, the standard deviation of the fit's residual; NaN where the model was not fitted.
        status: (n,) uint8, the constants of damper_msgs/DamperForces.
        verdict: what became of each sample that came (``signals.admission``).
    """

    kinematics: Kinematics
    force: np.ndarray
    stddev: np.ndarray
    status: np.ndarray
    verdict: np.ndarray

    def fields(self) -> dict[str, np.ndarray]:
        """The numeric fields of damper_msgs/DamperForces, each (n,); NaN means not available."""
        absent = np.full(self.force.size, np.nan)
        return {
            "displacement": self.kinematics.displacement,
            "velocity": self.kinematics.velocity,
            "acceleration": self.kinematics.acceleration,
            "force": self.force,
            "force_stddev": self.stddev,
            "force_min": absent,
            "force_max": absent,
            "dforce_dvelocity": absent,
            "dforce_dcurrent": absent,
            "status": self.status,
        }


class DamperEstimator:
    """Filter, model and status of one damper."""

    def __init__(self, model: DamperModel, cutoff: float, max_gap: float):
        """``cutoff`` in Hz (0: unfiltered), ``max_gap`` in s.

        Raises:
            InputError: where the model holds effects of the measurement chain, which belong to the signal map.
        """
        if model.channel_effects:
            raise InputError(
                f"model {model.name}: {', '.join(model.channel_effects)} belong to the measurement chain; "
                "mend the signal map and take them out of the model"
            )
        self.model = model
        self._differentiator = Differentiator(cutoff, max_gap)
        self._stream = model.stream()
        self._started = 0
        self._stddev = float(model.fit.get("residual_stddev", np.nan))
        region = model.fit.get("region") or {}
        self._region = [(REGION_ROWS[name], low, high) for name, (low, high) in region.items() if name in REGION_ROWS]

    def block(
        self,
        stamp: np.ndarray,
        displacement: np.ndarray,
        command: np.ndarray | float = np.nan,
        temperature: np.ndarray | float = np.nan,
        pressure: np.ndarray | float = np.nan,
    ) -> Estimates:
        """Estimates for the next samples in order of arrival; a block of one is the live case.

        Args:
            stamp: (n,) int64 ns.
            displacement: (n,) m.
            command, temperature, pressure: (n,) or one value each, NaN where there is none.
        """
        kinematics, verdict = self._differentiator.block(stamp, displacement, command, temperature, pressure)
        force = self._stream.force(kinematics.block)
        finite = np.isfinite(force)
        status = self._status(kinematics, finite)
        return Estimates(
            kinematics, np.where(finite, force, np.nan), np.full(force.size, self._stddev), status, verdict
        )

    def _status(self, kinematics: Kinematics, finite: np.ndarray) -> np.ndarray:
        outside = np.zeros(len(kinematics), bool)
        for row, low, high in self._region:
            outside |= (kinematics.block[row] < low) | (kinematics.block[row] > high)
        status = np.where(outside, EXTRAPOLATING, GOOD)
        status[kinematics.stamp - self._start_stamps(kinematics) < round(WARM_UP * 1e9)] = WARMING_UP
        status[~finite] = DEGRADED
        return status.astype(np.uint8)

    def _start_stamps(self, kinematics: Kinematics) -> np.ndarray:
        """(n,) int64: stamp of the reset that each sample follows."""
        starts = kinematics.stamp.copy()
        last = self._started
        for part in _stretches_from(kinematics.dt):
            if kinematics.dt[part.start] <= 0.0:
                last = int(kinematics.stamp[part.start])
            starts[part] = last
        self._started = last
        return starts


def _stretches_from(dt: np.ndarray) -> list[slice]:
    """Parts of a block between resets; the first may continue the block before."""
    edges = sorted({0, *np.flatnonzero(dt <= 0.0).tolist(), dt.size})
    return [slice(a, b) for a, b in zip(edges, edges[1:], strict=False)]
