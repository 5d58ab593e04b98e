"""The line of one damper over blocks: stamp and raw displacement in, estimate out.

``replay`` runs on this; the node runs the same kernels one sample at a time (``model.live_line``).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.errors import InputError
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.model.status import (
    COUNTS,
    DEGRADED,
    EXTRAPOLATING,
    GOOD,
    LEVELS,
    MARKS,
    REGION_ROWS,
    STALE,
    WARMING_UP,
    bounds_of,
    watch,
)
from damper_estimator.signals.fusion import Fusion, recent
from damper_estimator.signals.kinematics import Differentiator, Kinematics
from damper_estimator.signals.layout import A, V, X

__all__ = [
    "DEGRADED",
    "EXTRAPOLATING",
    "GOOD",
    "REGION_ROWS",
    "STALE",
    "WARMING_UP",
    "DamperEstimator",
    "Deployed",
    "Estimates",
    "deployed",
    "predict",
]
FIELDS = (
    "displacement", "velocity", "acceleration", "force", "force_stddev", "force_min", "force_max",
    "dforce_dvelocity", "dforce_dcurrent",
)  # fmt: skip


@dataclass(frozen=True)
class Estimates:
    """Estimates for the good ones among the samples that came.

    Attributes:
        kinematics: of the good samples, (n,).
        force: (n,) N; NaN where the model gave no finite number.
        given: (n,) N, what is published: the force, where that is not finite the last finite one (0 before the first).
        stddev: (n,) N, the standard deviation of the fit's residual; NaN where the model was not fitted.
        status: (n,) uint8, the constants of damper_msgs/DamperForces.
        verdict: what became of each sample that came (``signals.admission``).
        reach: (4, n), what can be reached by command and the slopes, from force_min to dforce_dcurrent; None where the
            force depends on none.
    """

    kinematics: Kinematics
    force: np.ndarray
    given: np.ndarray
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
            "force": self.given,
            "force_stddev": self.stddev,
            **dict(zip(FIELDS[5:], reach, strict=True)),
            "status": self.status,
        }


@dataclass(frozen=True, eq=False)
class Deployed:
    """A model as it runs on a vehicle.

    Attributes:
        model: of the damper.
        cutoff: Hz; 0 is unfiltered.
        max_gap: s.
        lead: s that the motion is predicted ahead to make up for the filter's delay; 0 is none.
        stddev: N, of the fit's residual; NaN where the model was not fitted.
        bounds: (8, 2), the region of the fit.
        fusion: where an accelerometer is taken in; then nothing is predicted.
    """

    model: DamperModel
    cutoff: float
    max_gap: float
    lead: float
    stddev: float
    bounds: np.ndarray
    fusion: Fusion | None = None

    @property
    def noise_cutoff(self) -> float:
        """Hz, of the filter through which the displacement's noise reaches the velocity."""
        return self.cutoff if self.fusion is None else 0.0


def deployed(
    model: DamperModel, cutoff: float, max_gap: float, lead: float = 0.0, fusion: Fusion | None = None
) -> Deployed:
    """Checks that a model can be run on a vehicle; arguments as in `Deployed`.

    Raises:
        InputError: where the model holds effects of the measurement chain, which belong to the signal map, or what it
            knows of its fit is malformed.
    """
    if model.channel_effects:
        raise InputError(
            f"model {model.name}: {', '.join(model.channel_effects)} belong to the measurement chain; "
            "mend the signal map and take them out of the model"
        )
    stddev, region = model.fit.get("residual_stddev"), model.fit.get("region") or {}
    faults = [] if stddev is None or _is_number(stddev) else [f"residual_stddev = {stddev!r} is not a number"]
    if not isinstance(region, Mapping):
        faults, region = [*faults, f"region must be a mapping, got {region!r}"], {}
    faults += [f"region.{name} must be two numbers, got {r!r}" for name, r in region.items() if not _is_range(r)]
    if faults:
        raise InputError(f"model {model.name}: fit: {'; '.join(faults)}; identify the model again, or remove fit")
    bounds = bounds_of({name: (float(r[0]), float(r[1])) for name, r in region.items()})
    lead = lead if fusion is None else 0.0
    return Deployed(model, cutoff, max_gap, lead, np.nan if stddev is None else float(stddev), bounds, fusion)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300


def _is_range(value: object) -> bool:
    return isinstance(value, list | tuple) and len(value) == 2 and all(_is_number(item) for item in value)


@compiled
def predict(lead, block):
    """Moves displacement and velocity of a block (8, n) ``lead`` s ahead, with the acceleration held."""
    for i in range(block.shape[1]):
        block[X, i] += lead * (block[V, i] + 0.5 * lead * block[A, i])
        block[V, i] += lead * block[A, i]


class DamperEstimator:
    """Filter, model and status of one damper, over blocks of any size."""

    def __init__(
        self, model: DamperModel, cutoff: float, max_gap: float, lead: float = 0.0, fusion: Fusion | None = None
    ):
        """``cutoff`` in Hz (0: unfiltered), ``max_gap`` in s, ``lead`` in s, ``fusion`` (`Deployed`).

        Raises:
            InputError: as `deployed`.
        """
        self.model = model
        self._deployed = deployed(model, cutoff, max_gap, lead, fusion)
        self._differentiator = Differentiator(cutoff, max_gap, fusion)
        self._stream = model.stream()
        self._marks, self._levels = np.zeros(MARKS, np.int64), np.zeros(LEVELS)
        self._counts = np.zeros(COUNTS, np.int64)

    def block(
        self,
        stamp: np.ndarray,
        displacement: np.ndarray,
        command: np.ndarray | float = np.nan,
        temperature: np.ndarray | float = np.nan,
        pressure: np.ndarray | float = np.nan,
        acceleration: np.ndarray | float = np.nan,
        felt_at: np.ndarray | int = 0,
    ) -> Estimates:
        """Estimates for the next samples in order of arrival.

        Args:
            stamp: (n,) int64 ns.
            displacement: (n,) m.
            command, temperature, pressure: (n,) or one value each, NaN where there is none.
            acceleration, felt_at: the same, m/s^2 and int64 ns, of the accelerometer where there is fusion.
        """
        own = self._deployed
        displacement = np.ascontiguousarray(displacement, float)
        felt = recent(acceleration, felt_at, stamp, own.max_gap)
        kinematics, verdict = self._differentiator.block(stamp, displacement, command, temperature, pressure, felt)
        if own.lead > 0.0:
            predict(own.lead, kinematics.block)
        force = self._stream.force(kinematics.block)
        status, given = np.empty(force.size, np.uint8), np.empty(force.size)
        watch(
            own.noise_cutoff, np.ascontiguousarray(stamp), displacement, verdict, self._differentiator.alone,
            kinematics.block, force, own.bounds, self._marks, self._levels, self._counts, status, given,
        )  # fmt: skip
        stddev = np.full(force.size, own.stddev)
        return Estimates(kinematics, np.where(np.isfinite(force), force, np.nan), given, stddev, status, verdict)
