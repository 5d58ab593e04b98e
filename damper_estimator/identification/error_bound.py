"""The bound of a model's errors that a node publishes with every force, estimated from the errors on the recordings."""

from __future__ import annotations

from collections.abc import Sequence
from math import gamma, log

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import DT

BLOCK = 0.25  # s, of which the largest error counts: errors at neighbouring samples are one event
DRIVING = 36_000.0  # s of such driving, in which one error exceeds the bound
SIGMAS = 3.0  # standard deviations that must cover the errors
COVERED = 0.999  # share of the recorded blocks below the bound; occasional glitches of the gauge are no model errors
FEWEST = 10  # blocks needed to estimate a shape
SHAPES = (0.0, 0.5)  # no heavier tail than Gumbel's, which glitches would suggest


def worst_errors(model: DamperModel, measurements: Sequence[Measurement]) -> np.ndarray:
    """(b,) N, the largest error of the force in each block of judged samples.

    The errors are taken behind the causal filter alone, as the estimate runs on a vehicle, not in the comparison's
    band.
    """
    worst = [np.empty(0)]
    for m in measurements:
        errors = np.abs(model.force(m.kinematics.block) - m.force)[m.judged]
        if errors.size:
            steps = m.kinematics.block[DT]
            length = max(round(BLOCK / np.median(steps[steps > 0.0])), 1) if steps.any() else 1
            worst.append(np.maximum.reduceat(errors, np.arange(0, errors.size, length)))
    return np.concatenate(worst)


def force_stddev(worst: np.ndarray) -> float:
    """The standard deviation of a normal error, N, of which three cover the model's errors in `DRIVING` seconds.

    The errors of a fit are no normal noise: they are those of a form that is not quite the damper's, large for a moment
    at reversals and steps of the command. Three times their rms would leave one sample in a hundred outside, and the
    largest of a minute is exceeded within an hour. The largest errors of blocks have a generalised extreme value
    distribution, F(e) = exp(-(1 - k (e - m) / s)^(1/k)); its parameters come from L-moments (Hosking, Wallis and Wood,
    Technometrics 27, 1985), and the bound is the error that one block in `DRIVING` / `BLOCK` exceeds.

    Args:
        worst: (b,) N, `worst_errors`; b >= 1.

    Returns:
        NaN where an error is not finite: then nothing bounds the next one.
    """
    if not np.isfinite(worst).all():
        return float("nan")
    seen = float(np.quantile(worst, COVERED, method="higher"))
    return max(_return_level(np.sort(worst), DRIVING / BLOCK), seen) / SIGMAS


def _return_level(ordered: np.ndarray, blocks: float) -> float:
    """The value that one block in ``blocks`` exceeds; that of a single block is unknown beyond its value."""
    n = ordered.size
    if n == 1:
        return float(ordered[0])
    rank = np.arange(n)
    b0, b1 = ordered.mean(), float(rank @ ordered) / (n * (n - 1))
    location, scale = b0, 2.0 * b1 - b0
    if scale <= 0.0:
        return float(ordered[-1])
    k = 0.0
    if n >= FEWEST:
        b2 = float((rank * (rank - 1)) @ ordered) / (n * (n - 1) * (n - 2))
        c = 2.0 / (3.0 + (6.0 * b2 - 6.0 * b1 + b0) / scale) - log(2.0) / log(3.0)
        k = float(np.clip(7.859 * c + 2.9554 * c**2, *SHAPES))
    rarity = -log(-np.log1p(-1.0 / blocks))
    if k < 1e-6:  # Gumbel's distribution, the limit
        s = scale / log(2.0)
        return float(location - np.euler_gamma * s + s * rarity)
    s = scale * k / ((1.0 - 2.0**-k) * gamma(1.0 + k))
    return float(location + s / k * (gamma(1.0 + k) - np.exp(-k * rarity)))
