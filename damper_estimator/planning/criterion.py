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
    s^2 = 4 sum_i (n_i^2 D_i s_m^2 + n_i D_i s_n^2) + (u (S_A + E) (r - 1))^2

n_i how often step i is driven, s_n^2 and s_m^2 the long-run variances of noise and of the model's form. A repeated step
averages noise, but repeats what the model's form gets wrong. u is the uncertainty of the expected error itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from scipy.special import log_ndtr, ndtr

from damper_estimator.diagnosis import Explanations, FittedExplanation, limits
from damper_estimator.numerics import long_run_variance
from damper_estimator.planning.simulated import Simulated

DRAWS = 8  # of the truth's parameters, antithetic, besides the values themselves
_REACH = 0.5  # of its size a parameter may be off or moved: derivatives do not hold beyond
_LEAST_FORM = 0.01  # of the force: what no model's form gets right
_UNSURE = 0.3  # of the expected error: errors of good recordings vary by that
_AT_REST = 0.1  # of the force's mean square on the recordings
_FREE = 1e-9  # the gauge's zero is held by nothing


@dataclass(frozen=True)
class Errors:
    """Errors to expect, estimated from the recordings.

    Attributes:
        noise: N^2 of a row, of the sensors.
        form: squared error of the model's form over the force's mean square.
        memory: rows after which the error is new.
        power: N^2, mean square of the force on the recordings.
    """

    noise: float
    form: float
    memory: float
    power: float

    def powers(self, forces: np.ndarray, slices: Sequence[slice]) -> np.ndarray:
        """(h, s) N^2 over which the form errs: the variance of the force (h, r) on each step, and a share of that on
        the recordings at least, since a model is not perfect at rest either.
        """
        found = [[force[part].var() if part.stop > part.start else 0.0 for part in slices] for force in forces]
        return np.maximum(np.array(found), _AT_REST * self.power)


def errors_of(found: Explanations, floor_n: float) -> Errors:
    """From what the best hypothesis leaves on the recordings, and their noise floor in N."""
    best = min(found.fitted, key=lambda hypothesis: float(np.sum(hypothesis.residual**2)))
    target = np.concatenate([part.target for part in found.rows])
    left, power = float(np.mean(best.residual**2)), max(float(np.mean(target**2)), 1e-300)
    noise = min(floor_n**2, left) if np.isfinite(floor_n) else 0.5 * left
    memory = long_run_variance(best.residual, found.rows[0].rate) / max(left, 1e-300)
    return Errors(noise, max((left - noise) / power, _LEAST_FORM**2), max(memory, 1.0), power)


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
    """

    pairs: tuple[Pair, ...]
    names: tuple[str, ...]
    expected: np.ndarray
    form: np.ndarray
    noise: np.ndarray

    def score(self, counts: np.ndarray) -> float:
        """Mean of the logarithm of P(right) over pairs and draws; what the search makes large."""
        return float(np.mean([np.mean(log_ndtr(self._margins(pair, counts)[0])) for pair in self.pairs]))

    def chances(self, counts: np.ndarray) -> Chances:
        """Of a test that drives step i ``counts[i]`` times; with several rivals each must be beaten (Bonferroni)."""
        lost: dict[int, dict[str, float]] = {}
        wrong: dict[int, dict[str, float]] = {}
        weakest = np.inf
        for pair in self.pairs:
            right, mistaken, evidence = self._margins(pair, counts)
            # Of a rival's forms the one that is hardest to beat counts.
            for into, chance in ((lost, 1.0 - float(np.mean(ndtr(right)))), (wrong, float(np.mean(ndtr(mistaken))))):
                of_truth = into.setdefault(pair.truth, {})
                of_truth[self.names[pair.rival]] = max(of_truth.get(self.names[pair.rival], 0.0), chance)
            weakest = min(weakest, evidence)
        chances = []
        for name in dict.fromkeys(self.names[k] for k in lost):
            forms = [k for k in lost if self.names[k] == name]
            right = float(np.mean([max(0.0, 1.0 - sum(lost[k].values())) for k in forms]))
            chances.append((name, right, min(1.0 - right, float(np.mean([sum(wrong[k].values()) for k in forms])))))
        right, mistaken = (float(np.mean([entry[k] for entry in chances])) for k in (1, 2))
        return Chances(right, mistaken, float(weakest), tuple(chances))

    def _margins(self, pair: Pair, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Standard deviations (d,) by which the truth is named alone, by which the rival is, and the evidence."""
        difference, each = pair.differences(counts)
        truth = pair.truth
        ours = pair.left[0] + float(counts @ self.expected[truth])
        theirs = pair.left[1] + float(counts @ self.expected[truth]) + difference
        r = ratio()
        chance = 4.0 * ((counts**2 * self.form[truth] + counts * self.noise[truth]) @ each)
        spread = np.sqrt(chance + (_UNSURE * ours * (r - 1.0)) ** 2 + 1e-300)
        rows = np.where(counts > 0, self.form[truth] + self.noise[truth], 1.0)
        evidence = float(np.mean((counts / rows) @ each) / 2.0)
        return (theirs - r * ours) / spread, (ours / r - theirs) / spread, evidence


def ratio() -> float:
    """Factor r between the squared errors of two phenomena from which on a diagnosis names one of them alone."""
    tied = limits().tied
    return float(((1.0 - tied) / tied) ** (1.0 / (limits().sharpness * (1.0 - limits().form_free))))


def criterion(found: Explanations, on: Simulated, steps: int, errors: Errors) -> Criterion:
    """The criterion of hypotheses that were simulated on some number of steps."""
    hypotheses = found.fitted
    slices = _slices(on.step, steps)
    variance = max(errors.noise + errors.form, 1e-300) * errors.memory
    draws = [_draws(hypothesis, variance, number) for number, hypothesis in enumerate(hypotheses)]
    pairs = [
        _pair(hypotheses, on, slices, draws, truth, rival)
        for truth, rival in permutations(range(len(hypotheses)), 2)
        if hypotheses[truth].phenomenon != hypotheses[rival].phenomenon
    ]
    counts = np.array([part.stop - part.start for part in slices])
    power = errors.powers(on.force, slices)
    return Criterion(
        tuple(pairs),
        tuple(hypothesis.phenomenon for hypothesis in hypotheses),
        counts * (errors.noise + errors.form * power),
        errors.form * power * errors.memory,
        np.full(power.shape, errors.noise),
    )


def information(hypothesis: FittedExplanation, variance: float) -> np.ndarray:
    """(k + 1, k + 1) of the old rows, each parameter held to the order of its size; the gauge's zero is free."""
    columns = hypothesis.sensitivity
    found = np.zeros((columns.shape[1] + 1,) * 2)
    found[:-1, :-1] = columns.T @ columns + np.eye(columns.shape[1]) * (variance / _REACH**2)
    found[-1, -1] = _FREE
    return found


def _slices(step: np.ndarray, steps: int) -> list[slice]:
    edges = np.searchsorted(step, np.arange(steps + 1))
    return [slice(int(a), int(b)) for a, b in zip(edges, edges[1:], strict=False)]


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
