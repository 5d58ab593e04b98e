"""At which speeds and frequencies a model erred when it was identified, and what that predicts on another motion.

A model without friction errs by as many newtons on a smaller motion, one without oil by more where the wheel moves
faster, and nothing has changed in the damper. The expected error is the largest of three: the same share of the force,
the same error at each speed, and the same share of the force in each octave:

    e^2 = max(s^2 |F|^2,  mean of e_v(|v|)^2,  sum over octaves of c_k |F_k|^2)

Its square is what the error of an unchanged damper seldom exceeds twice (`docs/diagnosis_history.md`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from damper_estimator.diagnosis.diagnosis_data import force_rows, targets, weight_of
from damper_estimator.identification.rows import Rows, split
from damper_estimator.model import DamperModel

KEY = "error_profile"
_SPEEDS = 8  # bins, of equal time
_LOWEST = 0.5  # Hz, end of the first octave
_LEAST_FORCE = 0.01  # of the squared force: an octave with less says nothing of the share that is wrong there
_DIGITS = 5


@dataclass(frozen=True)
class ErrorProfile:
    """The error of a model on the recordings of its identification.

    Attributes:
        speeds: (s + 1,) m/s, ends of the bins, ascending.
        errors: (s,) N^2, mean squared error in them.
        shares: (m,) squared error over squared force by octave, at most 1; the first ends at 0.5 Hz.
    """

    speeds: tuple[float, ...]
    errors: tuple[float, ...]
    shares: tuple[float, ...]

    def expected(self, rows: Sequence[Rows]) -> float:
        """N, rms of the error by speed or by octave, whichever is larger, on the motion and with the force of rows."""
        by_speed = float(np.mean(np.array(self.errors)[_bins(self.speeds, _speeds(rows))]))
        power = _by_octave(rows, targets(rows))
        last = np.minimum(np.arange(power.size), len(self.shares) - 1)
        return float(np.sqrt(max(by_speed, float(power @ np.array(self.shares)[last]))))

    def record(self) -> dict[str, object]:
        """For the model file."""
        names = {"speed_m_s": self.speeds, "squared_error_n2": self.errors, "squared_share_by_octave": self.shares}
        return {name: [float(f"{value:.{_DIGITS}g}") for value in values] for name, values in names.items()}


def profile_of(model: DamperModel, rows: Sequence[Rows]) -> ErrorProfile:
    """The profile on the rows of a model's identification, (r,) in all, r > 0."""
    error, force, speed = force_rows(model, rows) - targets(rows), targets(rows), _speeds(rows)
    ends = np.quantile(speed, np.linspace(0.0, 1.0, _SPEEDS + 1))
    bins = _bins(ends, speed)
    counts = np.bincount(bins, minlength=_SPEEDS)
    squared = error**2 / weight_of(rows)
    square = np.bincount(bins, squared, _SPEEDS) / np.maximum(counts, 1)
    square = np.where(counts > 0, square, float(squared.mean()))
    driven, wrong = _by_octave(rows, force), _by_octave(rows, error)
    shares = np.minimum(wrong / np.maximum(driven, _LEAST_FORCE * max(float(driven.sum()), 1e-300)), 1.0)
    return ErrorProfile(tuple(ends.tolist()), tuple(square.tolist()), tuple(shares.tolist()))


def recorded_profile(record: Mapping[str, Any]) -> ErrorProfile | None:
    """What a model's record of its fit holds; None where it holds nothing of the kind, or something else."""
    kept = record.get(KEY)
    try:
        names = ("speed_m_s", "squared_error_n2", "squared_share_by_octave")
        speeds, errors, shares = (tuple(float(value) for value in kept[name]) for name in names)
    except (TypeError, KeyError, ValueError):
        return None
    numbers = np.array([*speeds, *errors, *shares])
    fits = len(speeds) == len(errors) + 1 >= 2 and len(shares) >= 1 and bool((np.diff(speeds) >= 0.0).all())
    is_usable = fits and bool(np.isfinite(numbers).all() and (numbers >= 0.0).all())
    return ErrorProfile(speeds, errors, shares) if is_usable else None


def _speeds(rows: Sequence[Rows]) -> np.ndarray:
    return np.concatenate([np.abs(part.measurement.kinematics.velocity[part.picks]) for part in rows])


def _bins(ends: Sequence[float] | np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """(r,) int, the bin of each speed; the outermost bins hold what lies beyond."""
    return np.clip(np.searchsorted(ends, speeds, side="right") - 1, 0, len(ends) - 2)


def _by_octave(rows: Sequence[Rows], values: np.ndarray) -> np.ndarray:
    """(m,) N^2, mean square of weighted rows (r,) by octave: below 0.5 Hz, below 1 Hz, and so on."""
    octaves = 1 + int(np.ceil(np.log2(max(0.5 * max(part.rate for part in rows) / _LOWEST, 1.0))))
    found = np.zeros(octaves)
    for part, weighted in zip(rows, split(rows, values), strict=True):
        plain = weighted / np.sqrt(part.weight[part.picks])
        power = np.abs(np.fft.rfft(plain - plain.mean())) ** 2 * (2.0 / plain.size)
        hertz = np.fft.rfftfreq(plain.size, 1.0 / part.rate)
        octave = np.ceil(np.log2(np.maximum(hertz / _LOWEST, 1.0))).astype(int)
        found += np.bincount(np.minimum(octave, octaves - 1), power, octaves)
    return found / values.size
