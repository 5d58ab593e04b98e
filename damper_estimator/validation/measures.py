"""Error measures of a model against a measurement."""

from dataclasses import asdict, dataclass

import numpy as np


@dataclass(frozen=True)
class Measures:
    """Agreement over judged samples; e = modelled - measured force, both in band.

    Attributes:
        samples: how many were judged.
        rmse_n: sqrt(mean e^2), N.
        force_rms_n: sqrt(mean F^2), N.
        nrmse: rmse_n / force_rms_n.
        esr: var e / var F.
        fit_percent: 100 (1 - |e| / |F - mean F|).
        correlation: Pearson's, of modelled and measured force.
        peak_error_n: max |e|, N.
        energy_error: (sum F_model v dt - sum F v dt) / sum |F v| dt.
        bias_n: mean e, N.

    A quotient whose denominator is zero is NaN (null in JSON).
    """

    samples: int
    rmse_n: float
    force_rms_n: float
    nrmse: float
    esr: float
    fit_percent: float
    correlation: float
    peak_error_n: float
    energy_error: float
    bias_n: float

    def record(self) -> dict[str, object]:
        """The measures by name."""
        return asdict(self)


def measures(measured: np.ndarray, modelled: np.ndarray, velocity: np.ndarray, dt: np.ndarray) -> Measures:
    """Measures over samples: forces (n,) N in band, velocity (n,) m/s, steps (n,) s; n > 0."""
    error = modelled - measured
    rmse, rms = _rms(error), _rms(measured)
    centred, centred_model = measured - measured.mean(), modelled - modelled.mean()
    power = measured * velocity * dt
    return Measures(
        samples=int(error.size),
        rmse_n=rmse,
        force_rms_n=rms,
        nrmse=_quotient(rmse, rms),
        esr=_quotient(float(np.var(error)), float(np.var(measured))),
        fit_percent=100.0 * (1.0 - _quotient(rmse, _rms(centred))),
        correlation=_quotient(float(np.mean(centred * centred_model)), _rms(centred) * _rms(centred_model)),
        peak_error_n=float(np.max(np.abs(error))),
        energy_error=_quotient(float(np.sum(error * velocity * dt)), float(np.sum(np.abs(power)))),
        bias_n=float(error.mean()),
    )


def _rms(value: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(value))))


def _quotient(above: float, below: float) -> float:
    return above / below if below > 0.0 else float("nan")
