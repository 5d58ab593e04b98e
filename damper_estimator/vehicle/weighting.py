"""Sensitivity of seated people to vertical vibration: the frequency weighting Wk of ISO 2631-1.

    H(p) = H_h(p) H_l(p) H_t(p) H_s(p),      p = j 2 pi f,  w_i = 2 pi f_i

    H_h = 1 / (1 + sqrt(2) w1/p + (w1/p)^2)                     f1 = 0.4 Hz, high-pass
    H_l = 1 / (1 + sqrt(2) p/w2 + (p/w2)^2)                     f2 = 100 Hz, low-pass
    H_t = (1 + p/w3) / (1 + p/(Q4 w4) + (p/w4)^2)               f3 = f4 = 12.5 Hz, Q4 = 0.63
    H_s = (1 + p/(Q5 w5) + (p/w5)^2) / (1 + p/(Q6 w6) + (p/w6)^2) (w5/w6)^2
                                                                f5 = 2.37 Hz, f6 = 3.35 Hz, Q5 = Q6 = 0.91

Source: ISO 2631-1:1997, annex A, table A.1; the same numbers in ISO 8041.
"""

from functools import reduce
from math import pi, sqrt

import numpy as np
from scipy.signal import bilinear_zpk, sosfilt, zpk2sos

_W1, _W2, _W3, _W4, _W5, _W6 = (2.0 * pi * f for f in (0.4, 100.0, 12.5, 12.5, 2.37, 3.35))
_Q4, _Q5, _Q6 = 0.63, 0.91, 0.91

# Numerators and denominators in falling powers of p.
_SECTIONS = (
    ([1.0, 0.0, 0.0], [1.0, sqrt(2.0) * _W1, _W1**2]),
    ([_W2**2], [1.0, sqrt(2.0) * _W2, _W2**2]),
    ([_W4**2 / _W3, _W4**2], [1.0, _W4 / _Q4, _W4**2]),
    ([1.0, _W5 / _Q5, _W5**2], [1.0, _W6 / _Q6, _W6**2]),
)
LOWEST_RATE = 500.0
"""Hz; a lower rate would distort the upper end of the filter."""


def wk_gain(frequency: np.ndarray) -> np.ndarray:
    """|H| of the standard's transfer function at frequencies in Hz above 0, same shape."""
    p = 2j * pi * np.asarray(frequency, float)
    return np.abs(reduce(np.multiply, (np.polyval(b, p) / np.polyval(a, p) for b, a in _SECTIONS)))


def wk_weighted(acceleration: np.ndarray, step: float) -> np.ndarray:
    """Weighted acceleration (n,) of a record every ``step`` s, from rest; bilinear transform.

    Raises:
        ValueError: below 500 samples per second.
    """
    if step > 1.0 / LOWEST_RATE:
        raise ValueError(f"{1.0 / step:g} samples per second are too few for Wk; at least {LOWEST_RATE:g} are needed")
    zeros = np.concatenate([np.roots(b) for b, _ in _SECTIONS])
    poles = np.concatenate([np.roots(a) for _, a in _SECTIONS])
    gain = np.prod([b[0] for b, _ in _SECTIONS])
    return sosfilt(zpk2sos(*bilinear_zpk(zeros, poles, gain, 1.0 / step)), acceleration)
