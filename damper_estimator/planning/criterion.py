"""How well a test tells hypotheses apart: what is left of their difference once the rival was refitted.

T-optimal discrimination (Atkinson and Fedorov 1975, "The design of experiments for discriminating between two rival
models", Biometrika 62): with truth A, the difference that counts is the smallest that the rival B leaves over all its
parameters, those of the base model included, on the old and the new recordings together. Linearised about the fit to
the old ones, with M_B = J_B'J_B of the old rows:

    D = min over p of  |f_A - f_B - J_B p|^2 + p' M_B p                          N^2, summed over the rows

f in rows of the comparison's band, J with a column for the gauge's zero. A's own parameters are uncertain too: D is
that of draws from their covariance on the old recordings (Bayesian, as in Box and Hill 1967).

The decision is the one that a diagnosis takes from both recordings: a phenomenon is named alone once its rival leaves
more squared error by the factor r, with r^k = (1 - p) / p from the bound p of a tie and k, the sharpness of the
diagnosis for effects (its form-free tests are taken to speak for both alike).
With S_A, S_B left on the old recordings and E the squared error expected on the new one, of noise and of model form,

    P(right) = Phi((S_B + E + D - r (S_A + E)) / s),     P(wrong) = Phi(((S_A + E) / r - (S_B + E + D)) / s)
    s^2 = 4 sum_i (m_i D_i s_m^2 + n_i D_i s_n^2)

averaged over log E, which is uncertain by a factor of two. n_i is how often step i is driven, s_n^2 and s_m^2 are the
long-run variances of noise and of the model's form. A repeated step averages noise, but repeats what the model's form
gets wrong, m_i = n_i^2, and so does each cycle of a sine; at rest all rows err alike. Random motion is another one each
time, m_i = n_i.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from scipy.special import ndtr

from damper_estimator.diagnosis import Explanations, FittedExplanation, limits
from damper_estimator.planning.expected_error import Errors, repeated
from damper_estimator.planning.simulated import Simulated
from damper_estimator.planning.steps import Step

DRAWS = 8  # of the truth's parameters, antithetic, besides the values themselves
_REACH = 0.5  # of its size a parameter may be off or moved: derivatives do not hold beyond
_FACTORS, _WEIGHTS = 2.0 ** (np.sqrt(3.0) * np.array([-1.0, 0.0, 1.0])), np.array([1.0, 4.0, 1.0]) / 6.0
"""Nodes and weights of Gauss and Hermite for the expected squared error: it varies by a factor of two between good
recordings of one damper.
"""
_FREE = 1e-9  # the gauge's zero is held by nothing


@dataclass(frozen=True)
class Pair:
    """One hypothesis as the truth, another as the rival, and the information of each step.

    Attributes:
        truth, rival: positions in the hypotheses.
        normal: (s, k, k) J_B'J_B of each step; right: (s, k, d) J_B'(f_A - f_B) for each draw; square: (s, d).
        prior: (k, k) of the old recordings.
        left: S_A and S_B.
    """

    truth: int
    rival: int
    normal: np.ndarray
    right: np.ndarray
    square: np.ndarray
    prior: np.ndarray
    left: tuple[float, float]

    def differences(self, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """D (d,) of a test that drives step i ``counts[i]`` times, and D_i (s, d) of its steps."""
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
        return np.maximum(n @ each[used] + held, 0.0), each


@dataclass(frozen=True)
class Margins:
    """Of one pair, (d, 3) for each draw of the truth and each size of the expected error.

    Attributes:
        right, wrong: standard deviations by which the truth is named alone, and by which the rival is.
        progress: logarithm of the rival's squared error over the truth's, relative to that of r; from 0 to 1.
        evidence: see ``Chances``.
    """

    right: np.ndarray
    wrong: np.ndarray
    progress: np.ndarray
    evidence: float


@dataclass(frozen=True)
class Chances:
    """What a test leads to, the mean over the phenomena as truth.

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
    """

    pairs: tuple[Pair, ...]
    names: tuple[str, ...]
    expected: np.ndarray
    form: np.ndarray
    noise: np.ndarray
    is_random: np.ndarray

    def score(self, counts: np.ndarray) -> float:
        """Mean over pairs and draws of P(right) and of the progress towards a decision; what the search makes large.

        Progress leads the search where P is still flat. Both are bounded: a pair that nothing separates must not keep
        the search from separating the others.
        """
        margins = [self._margins(pair, counts) for pair in self.pairs]
        return 0.5 * float(np.mean([np.mean((ndtr(one.right) + one.progress) @ _WEIGHTS) for one in margins]))

    def chances(self, counts: np.ndarray) -> Chances:
        """Of a test that drives step i ``counts[i]`` times; with several rivals each must be beaten (Bonferroni)."""
        lost: dict[int, dict[str, float]] = {}
        wrong: dict[int, dict[str, float]] = {}
        weakest = np.inf
        for pair in self.pairs:
            margins = self._margins(pair, counts)
            named, renamed = (float(np.mean(ndtr(margin) @ _WEIGHTS)) for margin in (margins.right, margins.wrong))
            # Of a rival's forms the one that is hardest to beat counts.
            for into, chance in ((lost, 1.0 - named), (wrong, renamed)):
                of_truth = into.setdefault(pair.truth, {})
                of_truth[self.names[pair.rival]] = max(of_truth.get(self.names[pair.rival], 0.0), chance)
            weakest = min(weakest, margins.evidence)
        chances = []
        for name in dict.fromkeys(self.names[k] for k in lost):
            forms = [k for k in lost if self.names[k] == name]
            right = float(np.mean([max(0.0, 1.0 - sum(lost[k].values())) for k in forms]))
            chances.append((name, right, min(1.0 - right, float(np.mean([sum(wrong[k].values()) for k in forms])))))
        right, mistaken = (float(np.mean([entry[k] for entry in chances])) for k in (1, 2))
        return Chances(right, mistaken, float(weakest), tuple(chances))

    def _margins(self, pair: Pair, counts: np.ndarray) -> Margins:
        difference, each = pair.differences(counts)
        truth = pair.truth
        expected = float(counts @ self.expected[truth]) * _FACTORS
        ours, theirs = pair.left[0] + expected, pair.left[1] + expected + difference[:, None]
        r = ratio()
        repeats = repeated(counts, self.is_random)
        chance = 4.0 * ((repeats * self.form[truth] + counts * self.noise[truth]) @ each)
        spread = np.sqrt(chance + 1e-300)[:, None]
        rows = np.where(counts > 0, self.form[truth] + self.noise[truth], 1.0)
        return Margins(
            right=(theirs - r * ours) / spread,
            wrong=(ours / r - theirs) / spread,
            progress=np.clip(np.log(theirs / ours) / np.log(r), 0.0, 1.0),
            evidence=float(np.mean((counts / rows) @ each) / 2.0),
        )


def ratio() -> float:
    """Factor r between the squared errors of two phenomena from which on a diagnosis names one of them alone."""
    tied = limits().tied
    return float(((1.0 - tied) / tied) ** (1.0 / (limits().sharpness * (1.0 - limits().form_free))))


def criterion(found: Explanations, on: Simulated, steps: Sequence[Step], errors: Errors) -> Criterion:
    """The criterion of hypotheses that were simulated on steps."""
    hypotheses = found.fitted
    slices = on.slices
    variance = max(errors.usual, 1e-300) * errors.memory
    draws = [_draws(hypothesis, variance, number) for number, hypothesis in enumerate(hypotheses)]
    pairs = [
        _pair(hypotheses, on, slices, draws, truth, rival)
        for truth, rival in permutations(range(len(hypotheses)), 2)
        if hypotheses[truth].phenomenon != hypotheses[rival].phenomenon
    ]
    counts = np.array([part.stop - part.start for part in slices])
    form = errors.of_form(on, found.ranges)
    return Criterion(
        tuple(pairs),
        tuple(hypothesis.phenomenon for hypothesis in hypotheses),
        counts * (errors.noise + form),
        form * np.maximum(errors.memory * errors.alike(counts, steps), 1.0),
        np.full(form.shape, errors.noise),
        np.array([step.is_random for step in steps]),
    )


def information(hypothesis: FittedExplanation, variance: float) -> np.ndarray:
    """(k + 1, k + 1) of the old rows, each parameter held to the order of its size; the gauge's zero is free."""
    columns = hypothesis.sensitivity
    found = np.zeros((columns.shape[1] + 1,) * 2)
    found[:-1, :-1] = columns.T @ columns + np.eye(columns.shape[1]) * (variance / _REACH**2)
    found[-1, -1] = _FREE
    return found


def _draws(hypothesis: FittedExplanation, variance: float, seed: int) -> np.ndarray:
    """(k + 1, d) parameters of the truth less the fitted ones, in sizes, as the old recordings leave them uncertain."""
    known = information(hypothesis, variance)[:-1, :-1]
    root = np.linalg.cholesky(np.linalg.inv(known) * variance + 1e-15 * np.eye(len(known)))
    normal = np.random.default_rng([seed, 17]).standard_normal((len(known), DRAWS // 2))
    off = np.clip(root @ normal, -_REACH, _REACH)
    return np.vstack([np.hstack([np.zeros((len(known), 1)), off, -off]), np.zeros(DRAWS + 1)])


def _pair(
    hypotheses: Sequence[FittedExplanation],
    on: Simulated,
    slices: Sequence[slice],
    draws: Sequence[np.ndarray],
    truth: int,
    rival: int,
) -> Pair:
    columns = on.sensitivity[rival]
    change = (on.force[truth] - on.force[rival])[:, None] + on.sensitivity[truth] @ draws[truth]
    left = [float(np.sum(hypotheses[i].residual ** 2)) for i in (truth, rival)]
    best = min(left)
    return Pair(
        truth,
        rival,
        np.array([columns[part].T @ columns[part] for part in slices]),
        np.array([columns[part].T @ change[part] for part in slices]),
        np.array([np.sum(change[part] ** 2, axis=0) for part in slices]),
        information(hypotheses[rival], best / max(hypotheses[rival].residual.size, 1)),
        # Whichever is true explains the old recordings as well as the best does.
        (best, max(left[1], best)),
    )
