"""Numerical methods shared by fits and validation, one of each; independent of dampers."""

from damper_estimator.numerics.bootstrap import block_draws
from damper_estimator.numerics.bounded import bounded_least_squares
from damper_estimator.numerics.covariance import Directions, directions, standard_errors
from damper_estimator.numerics.differences import ROUGH, SMOOTH, stepped
from damper_estimator.numerics.form_free import COARSE_SHARES, FINE_SHARES, hats, lagging, play, speed_knots
from damper_estimator.numerics.long_run import (
    MEMORY,
    Spectrum,
    block_variance,
    long_run_variance,
    score_covariance,
    spectrum_of,
)
from damper_estimator.numerics.normal import damped_step, least_squares, normal_equations
from damper_estimator.numerics.quantiles import order_statistics
from damper_estimator.numerics.ranks import rank_correlation
from damper_estimator.numerics.triangle import triangle

__all__ = [
    "COARSE_SHARES",
    "FINE_SHARES",
    "MEMORY",
    "ROUGH",
    "SMOOTH",
    "Directions",
    "Spectrum",
    "block_draws",
    "block_variance",
    "bounded_least_squares",
    "damped_step",
    "directions",
    "hats",
    "lagging",
    "least_squares",
    "long_run_variance",
    "normal_equations",
    "order_statistics",
    "play",
    "rank_correlation",
    "score_covariance",
    "spectrum_of",
    "speed_knots",
    "standard_errors",
    "stepped",
    "triangle",
]
