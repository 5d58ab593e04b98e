"""Turns forces over a recording into the rows of the least-squares problem: in the comparison band, judged, thinned.

The error is compared behind a zero-phase low-pass at ``band``, so neighbouring samples repeat each other: about four
rows per period of the band contain all information. The reported error measures use every sample.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement, columns_zero_phase
from damper_estimator.signals.layout import COMMAND, PRESSURE, TEMPERATURE

ROWS_PER_BAND = 4.0  # rows per second over the band's frequency
SAMPLES_PER_BAND = 10.0  # least samples per second over it with which a model runs during a search
SLOW_CHANNELS = {COMMAND: "command", TEMPERATURE: "temperature", PRESSURE: "pressure"}
COMPARED, FREE, DRIFTING = range(3)
"""What becomes of the zero of the gauge: it is compared, or left out, or left out with its straight drift."""
_PROBE = 50  # samples at the end of a recording on which a model must return a force
_TRIAL = 2000  # samples on which the influence of a channel is tested
_SHORTEST = 0.5  # s; least length of a part of a recording between holes


@dataclass(frozen=True)
class Rows:
    """One measurement as rows.

    Attributes:
        measurement: where they come from.
        weight: (n,) weight of each sample's squared error.
        picks: (r,) int, the samples that are rows.
        target: (r,) measured force in band, N times root weight.
        rate: Hz, rows per second.
        setting: index of its setting in a joint fit.
        blind: (r, k) orthonormal directions in which nothing is compared; k is ``COMPARED``, ``FREE`` or ``DRIFTING``.
    """

    measurement: Measurement
    weight: np.ndarray
    picks: np.ndarray
    target: np.ndarray
    rate: float
    setting: int = 0
    blind: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def zero(self) -> int:
        """What becomes of the zero of the gauge: ``COMPARED``, ``FREE`` or ``DRIFTING``."""
        return self.blind.shape[1]

    def of(self, force: np.ndarray) -> np.ndarray:
        """(r,) rows of a force (n,) over the whole measurement."""
        rows = self.measurement.in_band(force)[self.picks] * np.sqrt(self.weight[self.picks])
        return rows - self.blind @ (self.blind.T @ rows) if self.blind.size else rows

    def of_columns(self, forces: Iterable[np.ndarray]) -> np.ndarray:
        """(r, k) rows of several forces (n,)."""
        band, dt = self.measurement.band, self.measurement.kinematics.dt
        rows = columns_zero_phase(band, dt, forces, self.picks) * np.sqrt(self.weight[self.picks])[:, None]
        return rows - self.blind @ (self.blind.T @ rows) if self.blind.size else rows

    def weighing(self, weight: np.ndarray) -> "Rows":
        """The same rows with another weight (n,)."""
        return _targeted(replace(self, weight=weight), self.zero)

    def thinned(self) -> "Rows":
        """The rows of the measurement at the rate that the band asks for; itself where it has no more."""
        measurement = self.measurement
        rate, band = measurement.kinematics.rate, measurement.band
        stride = int(rate / (SAMPLES_PER_BAND * band)) if band > 0.0 and np.isfinite(rate) else 1
        if stride < 2:
            return self
        weight = self.weight[measurement.kinematics.thinned(stride)]
        return rows_of(measurement.thinned(stride), weight, self.setting, self.zero)

    def part(self, part: slice) -> "Rows":
        """The rows of a part of the measurement, as a separate recording."""
        cut = self.measurement.part(part.start, part.stop)
        return rows_of(cut, self.weight[part], self.setting, self.zero)


def split(rows: Sequence[Rows], values: np.ndarray) -> list[np.ndarray]:
    """The part (r_i, ...) of each measurement of values (r, ...) over all rows."""
    return np.split(values, np.cumsum([recording.picks.size for recording in rows])[:-1]) if rows else []


def rows_of(measurement: Measurement, weight: float | np.ndarray = 1.0, setting: int = 0, zero: int = COMPARED) -> Rows:
    """The rows of a measurement.

    Args:
        weight: of the squared error, one number or (n,).
        zero: ``COMPARED``, ``FREE`` or ``DRIFTING``.
    """
    rate, band = measurement.kinematics.rate, measurement.band
    stride = max(1, int(rate / (ROWS_PER_BAND * band))) if band > 0.0 and np.isfinite(rate) else 1
    on_grid = np.arange(measurement.judged.size) % stride == 0
    picks = np.flatnonzero(measurement.judged & on_grid)
    weight = np.broadcast_to(np.asarray(weight, float), measurement.judged.shape)
    return _targeted(Rows(measurement, weight, picks, np.zeros(0), rate / stride, setting), zero)


def _targeted(rows: Rows, zero: int) -> Rows:
    if zero and rows.picks.size > 2:
        time = rows.measurement.kinematics.time[rows.picks]
        left_out = np.stack([np.ones_like(time), time - time.mean()], axis=1)[:, :zero]
        rows = replace(rows, blind=np.linalg.qr(left_out * np.sqrt(rows.weight[rows.picks])[:, None])[0])
    return replace(rows, target=rows.of(rows.measurement.force))


def usable(model: DamperModel, measurement: Measurement) -> list[slice]:
    """The parts of a measurement that a model can be fitted to; usually one, the whole.

    Where a slow channel that the model uses begins late (its first message comes some seconds into the recording),
    the samples before are left out: without it, effects give no force, which is right live but would be fitted as
    if it were the damper's.

    Raises:
        InputError: where the force was not measured, a channel that the model uses was not recorded, or its force
            is no number.
    """
    where, block = measurement.recording, measurement.kinematics.block
    if measurement.force is None:
        raise InputError(f"{where}: has no measured force of damper {measurement.damper!r}; this verb needs one")
    if not np.isfinite(measurement.force[measurement.judged]).all():
        raise InputError(
            f"{where}: the measured force of damper {measurement.damper!r} is not a number in places; "
            "clean the recording"
        )
    used = [row for row in SLOW_CHANNELS if np.isnan(block[row]).any() and _depends(model, block, row)]
    missing = [SLOW_CHANNELS[row] for row in used if np.isnan(block[row]).all()]
    if missing:
        raise InputError(
            f"{where}: has no {' and no '.join(missing)}, which model {model.name} uses; "
            "name the topic in the signal map or choose another model"
        )
    # The force before the first and after the last sample of the gauge need not be a number.
    good = np.isfinite(measurement.force) & np.isfinite(block[used]).all(axis=0)
    if not np.isfinite(model.force(np.ascontiguousarray(block[:, good][:, -_PROBE:]))).all():
        raise InputError(f"{where}: model {model.name} returns no finite force with its values; correct its values")
    if good.all():
        return [slice(0, good.size)]
    edges = np.flatnonzero(np.diff(good, prepend=False, append=False)).reshape(-1, 2).tolist()
    time = measurement.kinematics.time
    return [slice(a, b) for a, b in edges if time[b - 1] - time[a] >= _SHORTEST]


def check_motion(measurements: Sequence[Measurement]) -> None:
    """Refuses recordings none of which moves, or none of which has a force that changes; one at rest beside others has
    its use.

    Raises:
        InputError: one line.
    """
    where = ", ".join(dict.fromkeys(one.recording for one in measurements))
    for name, values in (
        ("displacement", [one.raw_displacement for one in measurements]),
        ("measured force", [one.force[one.judged] for one in measurements if one.force is not None]),
    ):
        present = [one for one in values if one.size]
        if present and all(np.ptp(one) == 0.0 for one in present):
            raise InputError(f"{where}: the {name} never changes; check the sensor, its topic and its field")


def _depends(model: DamperModel, block: np.ndarray, row: int) -> bool:
    """Whether the model's force changes with a slow channel, tested in the middle of a recording."""
    first = max(0, block.shape[1] // 2 - _TRIAL // 2)
    low, high = (np.array(block[:, first : first + _TRIAL], order="C") for _ in range(2))
    low[row], high[row] = 0.3, 1.7
    return not np.array_equal(model.force(low), model.force(high), equal_nan=True)


def excerpts(
    measurement: Measurement, samples: int, length: float = 3.0, interest: np.ndarray | None = None
) -> list[slice]:
    """Parts of ``length`` seconds, of about ``samples`` in total; the whole where it is shorter.

    One in each of as many equal shares of the recording: the one with the most motion and change of the slow channels,
    and the most ``interest`` (n,), each in comparison with its mean over the recording.
    """
    size = len(measurement.kinematics)
    each = max(int(length * measurement.kinematics.rate), 2)
    if size <= max(samples, 2 * each):
        return [slice(0, size)]
    count = max(samples // each, 1)
    lively = _liveliness(measurement)
    gathered = np.concatenate([[0.0], np.cumsum(np.zeros(size) if interest is None else interest)])
    parts = []
    for k in range(count):
        first, last = k * size // count, max((k + 1) * size // count - each, k * size // count)
        starts = np.unique(np.linspace(first, last, 2 * (last - first) // each + 1).astype(int))
        motion = np.array([float(lively[:, start : start + each].std(axis=1).mean()) for start in starts])
        ends = np.minimum(starts + each, size)
        amount = (gathered[ends] - gathered[starts]) / (ends - starts)
        mean = gathered[-1] / size
        start = min(int(starts[int(np.argmax(motion + (amount / mean if mean > 0.0 else 0.0)))]), size - each)
        parts.append(slice(start, start + each))
    return parts


def _liveliness(measurement: Measurement) -> np.ndarray:
    """(k, n) velocity and those slow channels that change, each over its standard deviation."""
    block = measurement.kinematics.block
    channels = [row for row in (measurement.kinematics.velocity, *block[list(SLOW_CHANNELS)]) if np.isfinite(row).all()]
    spreads = [float(row.std()) for row in channels]
    return np.stack([row / spread for row, spread in zip(channels, spreads, strict=True) if spread > 0.0] or [block[0]])


def natural_sizes(spreads: Sequence[np.ndarray]) -> tuple[float, float, float]:
    """Force (N), length (m) and time (s) of recordings, from the ``motion_moments`` of each."""
    together = [pooled(parts) for parts in np.stack(spreads, axis=1)]
    force, length, velocity = (float(np.sqrt(deviations / count)) for count, _, deviations in together)
    return force, length, length / velocity if velocity > 0.0 else float("nan")


def motion_moments(measurement: Measurement) -> np.ndarray:
    """(3, 3) ``moments`` of force, displacement and velocity at the judged samples."""
    judged, kinematics = measurement.judged, measurement.kinematics
    values = (measurement.force, kinematics.displacement, kinematics.velocity)
    return np.array([moments(channel[judged]) for channel in values])


def moments(values: np.ndarray) -> tuple[float, float, float]:
    """Number, mean, and sum of the squared deviations from it."""
    mean = float(values.mean()) if values.size else 0.0
    return float(values.size), mean, float(np.sum((values - mean) ** 2))


def pooled(parts: np.ndarray) -> tuple[float, float, float]:
    """The ``moments`` of all values from those of their parts (n, 3)."""
    count, mean, deviations = parts.T
    together = float(count @ mean / count.sum())
    return float(count.sum()), together, float(deviations.sum() + count @ (mean - together) ** 2)


def force_rms(measurements: Sequence[Measurement]) -> float:
    """RMS in N of the measured force in band about its mean, over all judged samples together."""
    return float(np.std(np.concatenate([m.in_band(m.force)[m.judged] for m in measurements])))


def pooled_error(model: DamperModel, measurements: Sequence[Measurement]) -> tuple[float, float, int]:
    """``rmse_n`` (N), ``esr`` and number of judged samples over all measurements together, at full rate."""
    errors, forces = [], []
    for measurement in measurements:
        measured = measurement.in_band(measurement.force)[measurement.judged]
        modelled = measurement.in_band(model.force(measurement.kinematics.block))[measurement.judged]
        errors.append(modelled - measured)
        forces.append(measured)
    error, force = np.concatenate(errors), np.concatenate(forces)
    variance = float(force.var())
    return (
        float(np.sqrt(np.mean(error**2))),
        float(error.var() / variance) if variance > 0.0 else float("nan"),
        error.size,
    )
