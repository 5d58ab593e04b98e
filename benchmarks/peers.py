"""Black-box peers for the table of real dampers: SysIdentPy's FROLS in free run, gradient boosting on short history.

They are needed only for the table: ``pip install sysidentpy scikit-learn``. Both receive the inputs of the models at
one rate: filtered displacement, velocity and acceleration; their output is the force through the same filter. Gradient
boosting is the best achievable static map of x, v, a and their last 50 ms.
"""

import contextlib
import io
import warnings
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND

RATE = 200.0  # Hz
HISTORY = (1, 2, 4, 6, 10)  # samples
LAGS = 3
CANDIDATES = ((1, 4), (1, 8), (2, 8), (2, 15), (3, 8), (3, 15), (3, 25))  # degree, terms

Peer = Callable[[Measurement], np.ndarray]


def inputs(measurement: Measurement, with_command: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Grid (m,) s, columns x, v, a on it (m, 3), or with the command (m, 4), and force in band (m,)."""
    motion = measurement.kinematics
    grid = np.arange(motion.time[0], motion.time[-1], 1.0 / RATE)
    columns = [
        np.interp(grid, motion.time, column) for column in (motion.displacement, motion.velocity, motion.acceleration)
    ]
    if with_command:
        columns.append(np.interp(grid, motion.time, motion.block[COMMAND]))
    force = np.interp(grid, motion.time, measurement.in_band(measurement.force))
    return grid, np.stack(columns, axis=1), force


def fit_boosting(measurements: Sequence[Measurement], with_command: bool = False) -> tuple[Peer, int]:
    """Gradient boosting on x, v, a, the command if wanted, and their history; also returns the number of trees."""
    from sklearn.ensemble import HistGradientBoostingRegressor

    parts = [inputs(m, with_command) for m in measurements]
    regressor = HistGradientBoostingRegressor(max_iter=300, learning_rate=0.05, random_state=0)
    regressor.fit(np.concatenate([_with_history(x) for _, x, _ in parts]), np.concatenate([f for _, _, f in parts]))

    def force(measurement: Measurement) -> np.ndarray:
        grid, x, _ = inputs(measurement, with_command)
        return np.interp(measurement.kinematics.time, grid, regressor.predict(_with_history(x)))

    return force, int(regressor.n_iter_)


def _with_history(x: np.ndarray) -> np.ndarray:
    padded = np.concatenate([np.repeat(x[:1], max(HISTORY), axis=0), x])
    past = [padded[max(HISTORY) - lag : padded.shape[0] - lag] for lag in HISTORY]
    return np.concatenate([x, *past], axis=1)


def fit_frols(measurements: Sequence[Measurement]) -> tuple[Peer, int]:
    """Polynomial NARX by forward regression orthogonal least squares, judged in free run; also returns the number of
    terms.

    Every signal is scaled to its rms, else the regression is ill-conditioned. Degree and number of terms are those with
    the best free run on the recordings of the fit.
    """
    parts = [inputs(m) for m in measurements]
    scale_x = np.concatenate([x for _, x, _ in parts]).std(axis=0)
    scale_f = float(np.concatenate([f for _, _, f in parts]).std())
    x = np.concatenate([columns for _, columns, _ in parts]) / scale_x
    y = (np.concatenate([f for _, _, f in parts]) / scale_f).reshape(-1, 1)
    trials = []
    for degree, terms in CANDIDATES:
        model = _frols(degree, terms, x, y)
        free = [_free_run(model, columns / scale_x, f / scale_f) for _, columns, f in parts]
        error = float(np.mean((np.concatenate(free) - y[:, 0]) ** 2))
        trials.append((error, terms, model))
    _, terms, best = min(trials, key=lambda trial: trial[0])

    def force(measurement: Measurement) -> np.ndarray:
        grid, columns, measured = inputs(measurement)
        free = _free_run(best, columns / scale_x, measured / scale_f) * scale_f
        return np.interp(measurement.kinematics.time, grid, free)

    return force, terms


def _frols(degree: int, terms: int, x: np.ndarray, y: np.ndarray):
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    lags = list(range(1, LAGS + 1))
    model = FROLS(
        order_selection=False, n_terms=terms, ylag=LAGS, xlag=[lags] * 3, basis_function=Polynomial(degree=degree)
    )
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        model.fit(X=x, y=y)
    return model


def _free_run(model, x: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Simulated (n,) from the first samples on; a diverging run is limited to ten times the force's rms."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        free = model.predict(X=x, y=f.reshape(-1, 1)[: model.max_lag])
    return np.nan_to_num(np.clip(np.ravel(free), -10.0, 10.0), nan=10.0)


PEERS: dict[str, Callable[[Sequence[Measurement]], tuple[Peer, int]]] = {
    "SysIdentPy FROLS, free run": fit_frols,
    "gradient boosting": fit_boosting,
}

PEERS_WITH_COMMAND: dict[str, Callable[[Sequence[Measurement]], tuple[Peer, int]]] = {
    "gradient boosting": partial(fit_boosting, with_command=True),
}
"""The same, for recordings with different commands."""
