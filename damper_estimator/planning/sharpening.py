"""How well a test determines parameters: D-optimality of the fit to the old and the new recording together.

A fit weighs all rows alike, whatever their errors:

    C = M^-1 S M^-1,    M = M_old + sum_i n_i J_i'J_i,    S = s^2 M_old + sum_i (n_i s_n^2 + n_i^2 s_i^2) J_i'J_i

with s^2, s_n^2 and s_i^2 the long-run variances of the old residual, of noise and of the model's form on step i, which
repeats errs alike. The volume of the parameters' common confidence region, det C, becomes smallest. Source: Wald 1943;
Fedorov 1972, Theory of Optimal Experiments; for C, Huber 1967.
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
    """Information of each step about the parameters, which are in sizes.

    Attributes:
        old: (k, k) M_old, each parameter held to the order of its size.
        variance: s^2.
        each: (s, k, k) J_i'J_i of each step.
        noise, form: s_n^2, and s_i^2 (s,).
        addresses, sizes, values: of the parameters (k,).
    """

    old: np.ndarray
    variance: float
    each: np.ndarray
    noise: float
    form: np.ndarray
    addresses: tuple[str, ...]
    sizes: np.ndarray
    values: np.ndarray

    def score(self, counts: np.ndarray) -> float:
        """By how much a test lowers half the logarithm of det C."""
        return 0.5 * float(np.subtract(*(np.linalg.slogdet(self._covariance(n))[1] for n in (0.0 * counts, counts))))

    def standard_errors(self, counts: np.ndarray) -> np.ndarray:
        """(k,) after a test that drives step i ``counts[i]`` times, old and new recordings together."""
        return np.sqrt(np.diag(self._covariance(counts))) * self.sizes

    def _covariance(self, counts: np.ndarray) -> np.ndarray:
        root = np.linalg.inv(self.old + np.tensordot(counts, self.each, 1))
        errors = counts * self.noise + counts**2 * self.form
        return root @ (self.variance * self.old + np.tensordot(errors, self.each, 1)) @ root


def sharpening(found: Explanations, on: Simulated, steps: Sequence[Step], errors: Errors) -> Sharpening:
    """The criterion of one model that was simulated on steps."""
    (hypothesis,) = found.fitted
    variance = float(np.mean(hypothesis.residual**2)) * errors.memory
    columns = on.sensitivity[0][:, :-1]  # a fit does not free the gauge's zero
    counts = np.array([part.stop - part.start for part in on.slices])
    slots = [hypothesis.model.slots[i] for i in hypothesis.free]
    return Sharpening(
        old=information(hypothesis, variance)[:-1, :-1],
        variance=variance,
        each=np.array([columns[part].T @ columns[part] for part in on.slices]),
        noise=errors.noise * errors.memory,
        form=errors.of_form(on, found.ranges)[0] * errors.alike(counts, steps),
        addresses=tuple(slot.address for slot in slots),
        sizes=hypothesis.sizes,
        values=np.array([slot.value for slot in slots]),
    )
