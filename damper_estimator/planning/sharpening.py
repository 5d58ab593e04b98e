"""How well a test determines parameters: D-optimality.

    log det (M / s_M + sum_i n_i J_i'J_i / s_i^2)

with M of the old recordings: the volume of the parameters' common confidence region becomes smallest. Source: Wald
1943; Fedorov 1972, Theory of Optimal Experiments. As in the criterion between hypotheses, s_i^2 are long-run variances.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis import Explanations
from damper_estimator.planning.criterion import information
from damper_estimator.planning.expected_error import Errors
from damper_estimator.planning.simulated import Simulated
from damper_estimator.planning.steps import Step


@dataclass(frozen=True)
class Sharpening:
    """Information of each step about the parameters.

    Attributes:
        prior: (k + 1, k + 1) information of the old recordings, parameters in sizes, the gauge's zero last.
        each: (s, k + 1, k + 1) of each step.
        addresses, sizes, values: of the parameters (k,).
    """

    prior: np.ndarray
    each: np.ndarray
    addresses: tuple[str, ...]
    sizes: np.ndarray
    values: np.ndarray

    def score(self, counts: np.ndarray) -> float:
        """Half the logarithm of the determinant, less that of the old recordings alone."""
        return 0.5 * float(np.linalg.slogdet(self._known(counts))[1] - np.linalg.slogdet(self.prior)[1])

    def standard_errors(self, counts: np.ndarray) -> np.ndarray:
        """(k,) after a test that drives step i ``counts[i]`` times, old and new recordings together."""
        return np.sqrt(np.diag(np.linalg.inv(self._known(counts)))[:-1]) * self.sizes

    def _known(self, counts: np.ndarray) -> np.ndarray:
        return self.prior + np.tensordot(counts, self.each, 1)


def sharpening(found: Explanations, on: Simulated, steps: Sequence[Step], errors: Errors) -> Sharpening:
    """The criterion of one model that was simulated on steps."""
    (hypothesis,) = found.fitted
    variance = float(np.mean(hypothesis.residual**2)) * errors.memory
    columns = on.sensitivity[0]
    counts = np.array([part.stop - part.start for part in on.slices])
    form = errors.form * errors.powers(on, found.ranges)[0]
    rows = errors.noise * errors.memory + form * errors.alike(counts, steps)
    each = np.array([columns[part].T @ columns[part] / row for part, row in zip(on.slices, rows, strict=True)])
    slots = [hypothesis.model.slots[i] for i in hypothesis.free]
    return Sharpening(
        information(hypothesis, variance) / variance,
        each,
        tuple(slot.address for slot in slots),
        hypothesis.sizes,
        np.array([slot.value for slot in slots]),
    )
