"""One damper on the live line: raw numbers as they arrive, estimates as the model gives them. Knows no ROS."""

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.model.estimator import DamperEstimator, Estimates
from damper_estimator.signals import Counts, DamperSignals
from damper_estimator.signals.admission import NON_FINITE, START

SLOW = ("command", "temperature", "pressure")


class LiveDamper:
    """Filter and model of one damper, the last values of its slow channels, and what became of its samples; final.

    Attributes:
        name: of the damper.
        signals: where its channels are, and their scales.
        model: what estimates its force.
        missing: messages that did not hold this damper.
        not_finite: estimates that the model could not give as a finite number.
    """

    def __init__(self, name: str, signals: DamperSignals, model: DamperModel, cutoff: float, max_gap: float) -> None:
        """``cutoff`` in Hz (0: unfiltered), ``max_gap`` in s."""
        self.name = name
        self.signals = signals
        self.model = model
        self.missing = 0
        self.not_finite = 0
        self._estimator = DamperEstimator(model, cutoff, max_gap)
        self._held = {role: float("nan") for role in SLOW}
        self._tally = [0] * (NON_FINITE + 1)

    @property
    def counts(self) -> Counts:
        """What became of the samples so far."""
        return Counts(sum(self._tally), *self._tally[START : NON_FINITE + 1])

    def hold(self, role: str, raw: float) -> None:
        """Keeps a slow channel's value until the next one arrives."""
        self._held[role] = float(getattr(self.signals, role).value(raw))

    def estimate(self, stamp: int, raw: float) -> Estimates:
        """The estimate for one sample, arrays of length 1 (0 where the sample was dropped); ``stamp`` in ns."""
        displacement = self.signals.displacement.value(np.array([raw]))
        estimates = self._estimator.block(np.array([stamp]), displacement, **self._held)
        self._tally[int(estimates.verdict[0])] += 1
        if estimates.force.size and not np.isfinite(estimates.force[0]):
            self.not_finite += 1
        return estimates


def warm_up(model: DamperModel, cutoff: float, max_gap: float) -> None:
    """Has the kernels of a model compiled now, so that the first message does not wait for it."""
    estimator = DamperEstimator(model, cutoff, max_gap)
    for millisecond in range(2):
        estimator.block(np.array([millisecond * 1_000_000]), np.zeros(1))
