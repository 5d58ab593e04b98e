"""The errors to expect on a test, of sensors and of the model's form, estimated from the recordings.

The error of the form is a function of the motion, so part of it lies at the frequencies that are driven. The other part
spreads as on the recordings. Where an effect was added, its form errs too, in proportion to what it adds to the force:
the best hypothesis left a share q of the squared error that it was to explain. On simulated dampers of other physics
the squared error of a new recording lies between those of two rules, it stays as it was and it grows like what the
effect adds, so their geometric mean is expected:

    e^2 = sqrt(w (w + q |f - f_0|^2)),   w = d g max(a + b |F|^2, sum over frequency of c(f) |F(f)|^2) + s^2

with d >= 1, by how far a step goes beyond the recorded strokes and speeds, g the usual growth of an error on recordings
that nothing was fitted to, f_0 the force without the effect, and c(f) the squared error over the squared force at a
frequency of the recordings. A road has little force at 20 Hz and a model may err there by half of it, which its error
on the road as a whole does not show. s is what a mean position beyond the recorded stroke adds: between there and twice
that far the static force of the model becomes as uncertain as 70 % of its change, the median on simulated dampers
(inside 15 %).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from damper_estimator.diagnosis import Explanations, limits
from damper_estimator.effects.trial import Ranges
from damper_estimator.identification.rows import Rows
from damper_estimator.model import DamperModel
from damper_estimator.numerics import Spectrum, long_run_variance, spectrum_of
from damper_estimator.planning.simulated import Simulated
from damper_estimator.planning.steps import Step

_LEAST_FORM = 0.01  # of the force: what no model's form gets right
_BINS = 10  # of the force, over which the squared error is averaged
_PASSES = 12  # of the fit of the squared error; its weights follow from it
_LOWEST = 0.5  # Hz, end of the first octave
_STATIC = 0.7  # of the change of the static force with the mean position: what no model knows twice as far out
_CENTRAL = 0.2  # of half the recorded stroke: mean positions that are those of the recordings
_DRIVEN = 0.5  # of the error of the form, where a step drives the force; the rest spreads as on the recordings


@dataclass(frozen=True)
class Errors:
    """What to expect of a row.

    Attributes:
        noise: N^2, of the sensors.
        constant: N^2, of the model's form whatever the force, as friction and gas leave on a slow motion.
        share: of the squared force about its mean, in addition.
        memory: rows after which the error is new.
        power: N^2, variance of the force on the recordings.
        spectrum: of the error on the recordings.
        shares: (m,) Hz and (m,), squared error over squared force by frequency; a model of damping and springs errs
            most where inertia, oil and valves come in.
        unexplained: q, share of the squared error that the best hypothesis leaves; 0 where none adds anything.
    """

    noise: float
    constant: float
    share: float
    memory: float
    power: float
    spectrum: Spectrum
    unexplained: float = 0.0
    shares: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def usual(self) -> float:
        """N^2, of a row on the recordings."""
        return self.noise + self.constant + self.share * self.power

    def alike(self, rows: np.ndarray, steps: Sequence[Step]) -> np.ndarray:
        """(s,) times that the form errs alike on a step of so many rows: once per cycle, but no more often than the
        error would be new otherwise.
        """
        return np.clip([step.cycles for step in steps], 1.0, np.maximum(rows / self.memory, 1.0))

    def spectrum_on(self, force: np.ndarray, rate: float) -> Spectrum:
        """Of the form's error on a step with this force (r,) in N at ``rate`` Hz; as on the recordings at rest."""
        moving = force - force.mean()
        if not np.mean(moving**2) > _LEAST_FORM**4 * self.power:
            return self.spectrum
        driven = spectrum_of([moving], [rate])
        usual = np.interp(driven.frequency, self.spectrum.frequency, self.spectrum.density)
        return Spectrum(driven.frequency, _DRIVEN * driven.density + (1.0 - _DRIVEN) * usual)

    def by_frequency(self, force: np.ndarray, rate: float) -> np.ndarray:
        """(h,) N^2, of the form's error if it is the same share of forces (h, r) at each frequency as recorded."""
        if self.shares is None:
            return np.zeros(len(force))
        moving = force - force.mean(axis=1, keepdims=True)
        power = np.abs(np.fft.rfft(moving, axis=1)) ** 2 * (2.0 / moving.shape[1] ** 2)
        at = np.fft.rfftfreq(moving.shape[1], 1.0 / rate)
        return power @ np.interp(at, *self.shares)

    def of_form(self, on: Simulated, ranges: Ranges, cautious: bool = True) -> np.ndarray:
        """(h, s) N^2 of a row of each step; ``cautious`` takes the larger of both rules, because an error of the form
        that is taken for a difference decides wrongly. A standard error needs what is right on average.
        """
        kinematics, picks = on.rows.measurement.kinematics, on.rows.picks
        away = (kinematics.displacement[picks] - ranges.middle) / (0.5 * ranges.stroke)
        beyond = np.maximum(np.abs(away), np.abs(kinematics.velocity[picks]) / ranges.speed)
        doubt = _static_doubts(on, away) if cautious else np.zeros(on.largest.size)
        found = np.zeros((len(on.force), on.largest.size))
        for k, part in enumerate(on.slices):
            if part.stop > part.start:
                usual = self.constant + self.share * on.force[:, part].var(axis=1)
                if cautious:
                    usual = limits().usual_growth * np.maximum(
                        usual, self.by_frequency(on.force[:, part], on.rows.rate)
                    )
                usual = usual * max(1.0, float(beyond[part].max())) + doubt[k] ** 2
                added = (on.force[:, part] - on.base[part]).var(axis=1)
                found[:, k] = np.sqrt(usual * (usual + self.unexplained * added))
        return found


def _static_doubts(on: Simulated, away: np.ndarray) -> np.ndarray:
    """(s,) N, how uncertain the model's static force is on each step, beyond the recorded stroke.

    Args:
        away: (r,) signed distance from the recordings' middle, in halves of the recorded stroke.
    """
    counts = np.maximum(np.bincount(on.step, minlength=on.largest.size), 1)
    means, distance = (np.bincount(on.step, values, on.largest.size) / counts for values in (on.base, away))
    central = np.abs(distance) <= max(_CENTRAL, float(np.abs(distance).min()))
    farthest = np.zeros(on.largest.size)
    np.maximum.at(farthest, on.step, np.abs(away))
    return _STATIC * np.clip(farthest - 1.0, 0.0, 1.0) * (means - np.median(means[central]))


def repeated(counts: np.ndarray, is_random: np.ndarray) -> np.ndarray:
    """(s,) by how much the error of the form weighs on steps driven ``counts`` times: it repeats with the motion."""
    return np.where(is_random, counts, counts**2)


def errors_of(found: Explanations, floor_n: float) -> Errors:
    """From what the best hypothesis leaves on the recordings, and their noise floor in N."""
    best = min(found.fitted, key=lambda hypothesis: float(np.sum(hypothesis.residual**2)))
    force = np.concatenate([part.target for part in found.rows])
    force = force - force.mean()
    left, power = float(np.mean(best.residual**2)), max(float(np.mean(force**2)), 1e-300)
    noise = min(floor_n**2, left) if np.isfinite(floor_n) else 0.5 * left
    memory = long_run_variance(best.residual, found.rows[0].rate) / max(left, 1e-300)
    constant, share = _over_force(force, np.maximum(best.residual**2 - noise, 0.0))
    ends, rates = np.cumsum([part.target.size for part in found.rows])[:-1], [part.rate for part in found.rows]
    spectrum = spectrum_of(np.split(best.residual, ends), rates)
    without = sum(float(np.sum((part.target - force_of(found.model, part)) ** 2)) for part in found.rows)
    unexplained = min(left * best.residual.size / max(without, 1e-300), 1.0) if best.effect else 0.0
    share = max(share, _LEAST_FORM**2)
    shares = _over_frequency(spectrum, spectrum_of(_split(force, ends), rates), left, power, noise)
    return Errors(noise, constant, share, max(memory, 1.0), power, spectrum, unexplained, shares)


def _split(rows: np.ndarray, ends: np.ndarray) -> list[np.ndarray]:
    return [part - part.mean() for part in np.split(rows, ends)]


def _over_frequency(
    error: Spectrum, force: Spectrum, left: float, power: float, noise: float
) -> tuple[np.ndarray, np.ndarray]:
    """Hz (m,), and squared error over squared force (m,) by octave, as ``Errors.shares``; noise is white."""
    middles, shares = [], []
    high = _LOWEST
    while high < 2.0 * error.frequency[-1]:
        inside = (error.frequency >= (0.5 * high if high > _LOWEST else 0.0)) & (error.frequency < high)
        if inside.any():
            middles.append(0.7 * high)
            erring = max(left * float(error.density[inside].mean()) - noise, 0.0)
            driven = power * float(np.interp(error.frequency[inside], force.frequency, force.density).mean())
            shares.append(min(erring / max(driven, 1e-300), 1.0))
        high *= 2.0
    return np.array(middles), np.array(shares)


def force_of(model: DamperModel, part: Rows) -> np.ndarray:
    """(r,) N of a model in the rows of a recording."""
    return part.of(np.nan_to_num(model.force(part.measurement.kinematics.block)))


def _over_force(force: np.ndarray, squared: np.ndarray) -> tuple[float, float]:
    """Constant part and share of the squared force of a squared error (r,), neither negative; right on average.

    Squares scatter in proportion to their mean, which is the weight of a bin: else those of the largest forces alone
    would count. The mean is that of the fit, for measured squares as weights would favour the small ones.
    """
    order = np.argsort(np.abs(force))
    parts = np.array_split(order, _BINS)
    power, error = (np.array([values[part].mean() for part in parts]) for values in (force**2, squared))
    usual = float(error.mean())
    expected = np.full(error.size, usual)
    found = np.array([usual, 0.0])
    for _ in range(_PASSES):
        weight = 1.0 / np.maximum(expected, 1e-3 * usual + 1e-300)
        found = nnls(np.column_stack([weight, weight * power]), weight * error)[0]
        expected = found[0] + found[1] * power
    constant, share = found * usual / max(float(expected.mean()), 1e-300)
    return float(constant), float(share)
