"""How well a test determines parameters: D-optimality of the fit to the old and the new recording together.

A fit weighs all rows alike, whatever their errors e:

    C = M^-1 S M^-1,    M = M_old + sum_i n_i J_i'J_i,    S = cov(J_old'e) + sum_i n_i (s_n^2 J_i'J_i + cov(J_i'e_i))

where s_n^2 is the variance of noise, and e_i the error of the model's form on step i, with the spectrum that the motion
of that step gives it: a sine is disturbed at its own frequency. The volume of the parameters' common confidence region,
det C, becomes smallest. Source: Wald 1943; Fedorov 1972, Theory of Optimal Experiments; for C, Huber 1967.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis import Explanations
from damper_estimator.planning.expected_error import Errors
from damper_estimator.planning.simulated import Simulated
from damper_estimator.planning.steps import Step


@dataclass(frozen=True)
class Sharpening:
    """Information of each step about the parameters, which are in sizes.

    Attributes:
        old: (k, k) M_old.
        disturbed: (k, k) cov(J_old'e).
        each, each_disturbed: (s, k, k) J_i'J_i and cov(J_i'e) of each step.
        addresses, sizes, values: of the parameters (k,).
    """

    old: np.ndarray
    disturbed: np.ndarray
    each: np.ndarray
    each_disturbed: np.ndarray
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
        return root @ (self.disturbed + np.tensordot(counts, self.each_disturbed, 1)) @ root


def sharpening(found: Explanations, on: Simulated, steps: Sequence[Step], errors: Errors) -> Sharpening:
    """The criterion of one model that was simulated on steps."""
    (hypothesis,) = found.fitted
    left = float(np.mean(hypothesis.residual**2))
    columns = on.sensitivity[0][:, :-1]  # a fit does not free the gauge's zero
    form, rate = errors.of_form(on, found.ranges, cautious=False)[0], on.rows.rate
    rows = found.rows[0].rate / rate  # of a recording, for one of a step
    each = rows * np.array([columns[part].T @ columns[part] for part in on.slices])
    spectra = [errors.spectrum_on(on.force[0, part], rate) for part in on.slices]
    of_form = [
        rows**2 * variance * spectrum.score_covariance(columns[part], rate)
        for variance, spectrum, part in zip(form, spectra, on.slices, strict=True)
    ]
    slots = [hypothesis.model.slots[i] for i in hypothesis.free]
    # What keeps a parameter from adding more than the force itself is no measurement, but as uncertain as one.
    most = np.sqrt(errors.power / np.maximum(np.mean(hypothesis.sensitivity**2, axis=0), 1e-12 * errors.power))
    held = np.diag(left * errors.memory / most**2)
    ends = np.cumsum([part.target.size for part in found.rows])[:-1]
    old = zip(np.split(hypothesis.sensitivity, ends), found.rows, strict=True)
    return Sharpening(
        old=held + hypothesis.sensitivity.T @ hypothesis.sensitivity,
        disturbed=left * (errors.memory * held + sum(errors.spectrum.score_covariance(j, r.rate) for j, r in old)),
        each=each,
        each_disturbed=errors.noise * rows * each + np.array(of_form),
        addresses=tuple(slot.address for slot in slots),
        sizes=hypothesis.sizes,
        values=np.array([slot.value for slot in slots]),
    )
