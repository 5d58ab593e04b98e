"""How well a test tells hypotheses apart: what is left of their difference once the rival was refitted.

T-optimal discrimination (Atkinson and Fedorov 1975, "The design of experiments for discriminating between two rival
models", Biometrika 62): with truth A, the difference that counts is the smallest that the rival B leaves over all its
parameters, those of the base model included, on the old and the new recordings together. Linearised about the fit to
the old ones, with M_B = J_B'J_B of the old rows:

    D = min over p of  |f_A - f_B - J_B p|^2 + p' M_B p                          N^2, summed over the rows

f in rows of the comparison's band, J with a column for the gauge's zero. A's own parameters are uncertain too: D is
that of draws from their covariance on the old recordings (Bayesian, as in Box and Hill 1967).

The decision is the one that a diagnosis takes from all recordings: a phenomenon is named alone once its odds against
each rival exceed (1 - p) / p, p the bound of a tie. Recordings judge one by one there. With o the odds before the test,
n_0 and n the independent recordings without and with it, w its weight among the recordings, and k the sharpness of the
diagnosis for effects (its form-free tests are taken to speak for both alike), the odds after the test are

    log odds = n (1 - w) (log o / n_0 + k log(1 + H / S)) + n w k log rho,      rho = (E + D + C_B) / (E + C_A)

S is what is left on the old recordings, H what the rival's refit adds there, E the squared error expected on the test,
of noise and of model form, and C = c (E + |f - f_0|^2) what a diagnosis charges for parameters, f_0 the force without
any of them. With r and q the ratios rho at which the truth and the rival would be named alone,

    P(right) = Phi((E + D + C_B - r (E + C_A)) / s),      P(wrong) = Phi((q (E + C_A) - (E + D + C_B)) / s)
    s^2 = 4 sum_i (m_i D_i s_m^2 + n_i D_i s_n^2)

averaged over log E, which is uncertain by a factor of 2.5. n_i is how often step i is driven, s_n^2 and s_m^2 are the
long-run variances of noise and of the model's form. A repeated step averages noise, but repeats what the model's form
gets wrong, m_i = n_i^2, and so does each cycle of a sine; at rest all rows err alike. Random motion is another one each
time, m_i = n_i.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial.hermite_e import hermegauss
from scipy.special import ndtr

from damper_estimator.diagnosis import limits
from damper_estimator.planning.expected_error import repeated

_UNSURE = 2.5  # factor by which the expected squared error is wrong on new motions of dampers of other physics
_NODES, _WEIGHTS = hermegauss(7)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()
_FACTORS = _UNSURE**_NODES
_LEAST = 1e-9  # of the expected squared error: what does not vary decides by its sign
_FARTHEST = 20.0  # logarithm of a ratio of squared errors: nothing is further


@dataclass(frozen=True)
class Pair:
    """One hypothesis as the truth, another as the rival, and the information of each step.

    Attributes:
        truth, rival: positions in the hypotheses.
        normal: (s, k, k) J_B'J_B of each step; right: (s, k, d) J_B'(f_A - f_B) for each draw; square: (s, d).
        prior: (k, k) of the old recordings.
        ahead: log o, of the truth against the rival before the test.
        left: S.
        charged: (2, s) C_A and C_B of each step; nothing without.
    """

    truth: int
    rival: int
    normal: np.ndarray
    right: np.ndarray
    square: np.ndarray
    prior: np.ndarray
    ahead: float
    left: float
    charged: np.ndarray | None = None

    def differences(self, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """H (d,) of a test that drives step i ``counts[i]`` times, and D_i (s, d) of its steps."""
        used = np.flatnonzero(counts)
        n = counts[used]
        normal = np.tensordot(n, self.normal[used], 1) + self.prior
        right = np.tensordot(n, self.right[used], 1)
        moved = np.linalg.solve(normal, right)
        each = np.zeros(self.square.shape)
        each[used] = (
            self.square[used]
            - 2.0 * np.einsum("skd,kd->sd", self.right[used], moved)
            + np.einsum("kd,skl,ld->sd", moved, self.normal[used], moved, optimize=True)
        )
        each = np.maximum(each, 0.0)
        held = np.einsum("kd,kl,ld->d", moved, self.prior, moved, optimize=True)
        return np.maximum(held, 0.0), each


@dataclass(frozen=True)
class Weighing:
    """How a diagnosis weighs the test beside the recordings that are there.

    Attributes:
        before, after: n_0 and n, independent recordings without and with the test.
        weight: w of the test.
    """

    before: float = 1.0
    after: float = 2.0
    weight: float = 0.5

    def carried(self, ahead: float, held: np.ndarray) -> np.ndarray:
        """Log odds that the old recordings give, from those before the test and the factor (1 + H / S) of the rival."""
        return self.after * (1.0 - self.weight) * (ahead / self.before + sharpness() * np.log(held))

    def ratio(self, log_odds: np.ndarray) -> np.ndarray:
        """rho that adds such log odds."""
        return np.exp(np.clip(log_odds / (self.after * self.weight * sharpness()), -_FARTHEST, _FARTHEST))


@dataclass(frozen=True)
class Margins:
    """Of one pair, (d, f) for each draw of the truth and each size of the expected error.

    Attributes:
        right, wrong: standard deviations by which the truth is named alone, and by which the rival is.
        progress: towards the odds of a decision, as their share; from 0 to 1.
        evidence: see ``Chances``.
    """

    right: np.ndarray
    wrong: np.ndarray
    progress: np.ndarray
    evidence: float


@dataclass(frozen=True)
class Chances:
    """What a test leads to, the mean over the phenomena as truth, each by its probability.

    Attributes:
        right: probability that the truth is named alone.
        wrong: that another one is.
        evidence: D / (2 s_n^2 + 2 s_m^2) of the weakest pair in nats, as if rows forgot each other after ``memory``.
        by_truth: phenomenon, right and wrong where it is what is missing. A phenomenon that another one can imitate
            (a spring, by gas in a large volume) is never confirmed alone, but the other one may be.
    """

    right: float
    wrong: float
    evidence: float
    by_truth: tuple[tuple[str, float, float], ...] = ()

    @property
    def best(self) -> float:
        """P(right) of the phenomenon that is the easiest to confirm."""
        return max((right for _, right, _ in self.by_truth), default=self.right)

    @property
    def tied(self) -> float:
        """That the tie stays."""
        return max(0.0, 1.0 - self.right - self.wrong)


@dataclass(frozen=True)
class Criterion:
    """Everything that decides between the hypotheses, step by step.

    Attributes:
        names: (h,) phenomena of the hypotheses.
        expected: (h, s) squared error expected of each step, by the truth.
        form, noise: (h, s) long-run variances of a row, s_m^2 and s_n^2.
        is_random: (s,) bool, steps whose motion is another one each time.
        probable: of each phenomenon, before the test; all alike without.
        weighing: of the test in the decision.
    """

    pairs: tuple[Pair, ...]
    names: tuple[str, ...]
    expected: np.ndarray
    form: np.ndarray
    noise: np.ndarray
    is_random: np.ndarray
    probable: Mapping[str, float] = field(default_factory=dict)
    weighing: Weighing = Weighing()

    def score(self, counts: np.ndarray) -> float:
        """Mean over pairs and draws of P(right) and of the progress towards a decision; what the search makes large.

        Progress leads the search where P is still flat. Both are bounded: a pair that nothing separates must not keep
        the search from separating the others.
        """
        margins = [self._margins(pair, counts) for pair in self.pairs]
        names = [self.names[pair.truth] for pair in self.pairs]
        weights = np.array([self._weight(name) / names.count(name) for name in names])
        each = np.array([np.mean((ndtr(one.right) + one.progress) @ _WEIGHTS) for one in margins])
        return 0.5 * float(weights @ each / weights.sum())

    def _weight(self, name: str) -> float:
        return self.probable.get(name, 1.0)

    def chances(self, counts: np.ndarray) -> Chances:
        """Of a test that drives step i ``counts[i]`` times; with several rivals each must be beaten."""
        beaten: dict[int, dict[str, np.ndarray]] = {}  # (d, f) by truth and rival
        wrong: dict[int, dict[str, float]] = {}
        weakest = np.inf
        for pair in self.pairs:
            margins, rival = self._margins(pair, counts), self.names[pair.rival]
            # Of a rival's forms the one that is hardest to beat counts.
            named, renamed = beaten.setdefault(pair.truth, {}), wrong.setdefault(pair.truth, {})
            named[rival] = np.minimum(named.get(rival, 1.0), ndtr(margins.right))
            renamed[rival] = max(renamed.get(rival, 0.0), float(np.mean(ndtr(margins.wrong) @ _WEIGHTS)))
            weakest = min(weakest, margins.evidence)
        chances = []
        for name in dict.fromkeys(self.names[k] for k in beaten):
            forms = [k for k in beaten if self.names[k] == name]
            # Given the truth's parameters and the size of the error, the rivals are beaten independently.
            each = [float(np.mean(np.prod(list(beaten[k].values()), axis=0) @ _WEIGHTS)) for k in forms]
            right = float(np.mean(each))
            chances.append((name, right, min(1.0 - right, float(np.mean([sum(wrong[k].values()) for k in forms])))))
        weights = [self._weight(name) for name, _, _ in chances]
        right, mistaken = (float(np.average([entry[k] for entry in chances], weights=weights)) for k in (1, 2))
        return Chances(right, mistaken, float(weakest), tuple(chances))

    def _margins(self, pair: Pair, counts: np.ndarray) -> Margins:
        held, each = pair.differences(counts)
        truth = pair.truth
        expected = float(counts @ self.expected[truth]) * _FACTORS + 1e-300
        ours, theirs = expected[None], expected + (counts @ each)[:, None]
        if pair.charged is not None:
            ours, theirs = (one + counts @ extra for one, extra in zip((ours, theirs), pair.charged, strict=True))
        sure = decisive()
        carried = self.weighing.carried(pair.ahead, 1.0 + held / pair.left)[:, None]
        repeats = repeated(counts, self.is_random)
        chance = 4.0 * ((repeats * self.form[truth] + counts * self.noise[truth]) @ each)
        spread = np.sqrt(chance)[:, None] + _LEAST * ours
        rows = np.where(counts > 0, self.form[truth] + self.noise[truth], 1.0)
        gained = np.log(theirs / ours) / np.log(self.weighing.ratio(np.ones(1)))
        return Margins(
            right=(theirs - self.weighing.ratio(sure - carried) * ours) / spread,
            wrong=(self.weighing.ratio(-sure - carried) * ours - theirs) / spread,
            progress=np.clip((carried + gained) / sure, 0.0, 1.0),
            evidence=float(np.mean((counts / rows) @ each) / 2.0),
        )


def sharpness() -> float:
    """k, by which the probability of a phenomenon falls with the squared error that its effect leaves."""
    return limits().sharpness * (1.0 - limits().form_free)


def decisive() -> float:
    """Log odds of two phenomena from which on a diagnosis names one of them alone."""
    return float(np.log((1.0 - limits().tied) / limits().tied))
