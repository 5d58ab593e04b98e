"""The data of a diagnosis: rows to fit to, rows to judge on, and the weight of each.

    weight = s^2 / (s_F^2 + (dF/dv s_v)^2)

s_F is the gauge's noise in band with a hundredth of the force for the form of the model, s_v the velocity's noise in
band, dF/dv the slope of the model at each sample: where the curve is steep, noise of the displacement is noise of
the force. The zero of the gauge and its straight drift belong to each recording and are left out of the comparison; the
drift is compared where it is most of the error, as with warm gas, and no movement of the zero was found.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from damper_estimator.diagnosis.by_recording import ByRecording, by_recording, independent
from damper_estimator.diagnosis.division import all_divided
from damper_estimator.effects.trial import Ranges
from damper_estimator.identification import rows_of, usable
from damper_estimator.identification.fit_record import recorded_region
from damper_estimator.identification.rigid import without_compliances
from damper_estimator.identification.rows import COMPARED, DRIFTING, FREE, Rows
from damper_estimator.model import DamperModel
from damper_estimator.model.element import walk
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, DT, TEMPERATURE, A, V, X
from damper_estimator.validation.noise import white_density

BLOCK = 1.0  # s, what the bootstrap draws; residuals forget within it
_FORM = 0.01  # of the force's rms: what no model's form gets right
_PEAK = 4.0  # standard deviations, of the noise in some ten thousand samples
_SLOPE_STEP = 0.01  # m/s
_RUNAWAY = 1e12  # N s/m
_STEEPEST = 6.0  # weights fall no lower than 1 / (1 + 6^2)


@dataclass(frozen=True)
class DiagnosisData:
    """Rows of all recordings of one damper.

    Attributes:
        fit, unseen: rows that parameters are fitted to, and rows that explanations are judged on.
        blocks: (r,) int, the block of each unseen row.
        ranges: what the recordings drive.
        change: probability that something has changed since the model was identified; 1 where that is not asked.
        zero_change: the same of the error with the gauge's zero in it.
        usual: share of the squared error that the model left when it was identified; 0 where that is not known.
    """

    fit: tuple[Rows, ...]
    unseen: tuple[Rows, ...]
    blocks: np.ndarray
    ranges: Ranges
    change: float = 1.0
    zero_change: float = 1.0
    usual: float = 0.0

    @cached_property
    def force_rms(self) -> float:
        """Of the unseen rows, N."""
        return float(np.sqrt(np.mean(targets(self.unseen) ** 2)))

    @cached_property
    def fit_recordings(self) -> ByRecording:
        """Whose the fitted rows are."""
        return by_recording(self.fit)

    @cached_property
    def unseen_recordings(self) -> ByRecording:
        """Whose the unseen rows are."""
        return by_recording(self.unseen)

    @cached_property
    def independent(self) -> float:
        """How many independent ones the recordings are."""
        return independent(self.fit)

    def by_recording(self, blocks: np.ndarray) -> np.ndarray:
        """(b, recordings) sums over blocks (b,) of the unseen rows, each in the column of its recording."""
        owner = np.zeros(blocks.size, int)
        owner[self.blocks] = self.unseen_recordings.rows
        return np.where(owner[:, None] == np.arange(self.unseen_recordings.weight.size), blocks[:, None], 0.0)

    @cached_property
    def with_zero(self) -> "DiagnosisData":
        """The same rows with the gauge's zero and drift in the comparison."""
        compared = self._comparing(COMPARED)
        return replace(compared, ranges=replace(self.ranges, with_mean=True), change=self.zero_change)

    @property
    def zero(self) -> int:
        """What becomes of the zero of the gauge, see ``identification.rows``."""
        return self.fit[0].zero

    @property
    def with_drift(self) -> "DiagnosisData":
        """The same rows with the drift of the gauge's zero in the comparison."""
        return self._comparing(FREE)

    def _comparing(self, zero: int) -> "DiagnosisData":
        fit, unseen = (
            tuple(rows_of(part.measurement, part.weight, zero=zero) for part in group)
            for group in (self.fit, self.unseen)
        )
        return replace(self, fit=fit, unseen=unseen)


def data_of(model: DamperModel, fit: Sequence[Measurement], unseen: Sequence[Measurement]) -> DiagnosisData:
    """The data of a model and its recordings; without ``unseen`` 40 % of each is kept back (``divided``).

    Raises:
        InputError: where a recording cannot be judged with this model.
    """
    if not unseen:
        fit, unseen = all_divided(fit)
    fit_rows, unseen_rows = _rows(model, fit), _rows(model, unseen)
    return DiagnosisData(
        fit_rows, unseen_rows, _blocks(unseen_rows), ranges_of([part.measurement for part in fit_rows], model)
    )


def force_rows(model: DamperModel, rows: Sequence[Rows]) -> np.ndarray:
    """(r,) rows of a model's force over all recordings."""
    return np.concatenate([part.of(model.force(part.measurement.kinematics.block)) for part in rows])


def targets(rows: Sequence[Rows]) -> np.ndarray:
    """(r,) rows of the measured force."""
    return np.concatenate([part.target for part in rows])


def unweighted(rows: Sequence[Rows], errors: np.ndarray) -> float:
    """RMS in N of errors (r,) in rows, their weights taken off again."""
    return float(np.sqrt(np.mean(errors**2 / weight_of(rows))))


def error_of(model: DamperModel, rows: Sequence[Rows]) -> float:
    """RMS in N of a model's error on rows, with what becomes of the gauge's zero there."""
    return unweighted(rows, force_rows(model, rows) - targets(rows))


def weight_of(rows: Sequence[Rows]) -> np.ndarray:
    """(r,) weights of the squared errors of all rows."""
    return np.concatenate([part.weight[part.picks] for part in rows])


def dynamic_force(rows: Sequence[Rows]) -> float:
    """RMS in N of the force without each recording's zero and drift: what errors are shares of. A static gas force says
    nothing of how large an error is.
    """
    return unweighted(rows, targets(rows))


def _rows(model: DamperModel, measurements: Sequence[Measurement]) -> tuple[Rows, ...]:
    rows = []
    for measurement in measurements:
        for part in usable(model, measurement):
            whole = part == slice(0, len(measurement.kinematics))
            window = measurement if whole else measurement.part(part.start, part.stop)
            rows.append(rows_of(window, weights(model, window), zero=DRIFTING).thinned())
    return tuple(part for part in rows if part.picks.size > 2)


def weights(model: DamperModel, measurement: Measurement) -> np.ndarray:
    """(n,) weights of the squared error, 1 on average over the judged samples."""
    kinematics, band = measurement.kinematics, measurement.band or 0.25 * measurement.kinematics.rate
    judged = measurement.judged
    own_rate = kinematics.rate
    gauge_rate = own_rate * measurement.gauge.size / max(measurement.counts.samples, 1)
    gauge = np.nan_to_num(white_density(measurement.gauge, gauge_rate)) * band
    displacement = np.nan_to_num(white_density(measurement.raw_displacement, own_rate))
    velocity = (2.0 * np.pi) ** 2 * displacement * band**3 / 3.0
    force = float(np.var(measurement.force[judged])) if judged.any() else 1.0
    slope = slope_of(model, kinematics.block)
    floor = gauge + _FORM**2 * force
    noise = floor + np.minimum(slope**2 * velocity, _STEEPEST**2 * floor)
    weight = 1.0 / np.maximum(noise, 1e-12)
    return weight / (weight[judged].mean() if judged.any() else weight.mean())


def slope_of(model: DamperModel, block: np.ndarray) -> np.ndarray:
    """(n,) dF/dv of a model on a motion, N s/m; 0 where it has no finite force."""
    high, low = block.copy(), block.copy()
    high[V] += _SLOPE_STEP
    low[V] -= _SLOPE_STEP
    with np.errstate(invalid="ignore", over="ignore"):  # trial models may run away
        slope = (model.force(high) - model.force(low)) / (2.0 * _SLOPE_STEP)
    return np.where(np.abs(slope) < _RUNAWAY, slope, 0.0)


def _blocks(rows: Sequence[Rows]) -> np.ndarray:
    numbers, first = [], 0
    for part in rows:
        time = part.measurement.kinematics.time[part.picks]
        number = np.unique(((time - time[0]) / BLOCK).astype(int), return_inverse=True)[1]
        numbers.append(first + number)
        first += int(number[-1]) + 1
    return np.concatenate(numbers)


def ranges_of(measurements: Sequence[Measurement], model: DamperModel | None = None) -> Ranges:
    """What recordings drive, and where the model was identified."""

    def gathered(column) -> np.ndarray:
        return np.concatenate([np.asarray(column(m))[m.judged] for m in measurements])

    def ends(row: int) -> tuple[float, float] | None:
        return ends_without_noise(gathered(lambda m: m.kinematics.block[row]))

    whole, of_oil = _forces_at_rest(model, measurements[0]) if model is not None else (0.0, 0.0)
    x = gathered(lambda m: m.kinematics.displacement)
    force = gathered(lambda m: m.force)
    low, high = np.quantile(x, [0.001, 0.999])
    return Ranges(
        compression=float(low),
        extension=float(high),
        speed=float(np.quantile(np.abs(gathered(lambda m: m.kinematics.velocity)), 0.995)),
        acceleration=float(np.quantile(np.abs(gathered(lambda m: m.kinematics.acceleration)), 0.995)),
        force=float(force.std()),
        seconds=min(float(np.sum(m.kinematics.dt[m.judged])) for m in measurements),
        command=ends(COMMAND),
        temperature=ends(TEMPERATURE),
        model_command=recorded_region(model, "command") if model is not None else None,
        model_temperature=recorded_region(model, "temperature") if model is not None else None,
        at_rest=whole,
        oil_at_rest=of_oil,
        spring_rate=measurements[0].signals.spring_rate,
        preload=measurements[0].signals.preload,
        identified=_identified(model),
    )


def ends_without_noise(values: np.ndarray) -> tuple[float, float] | None:
    """Lowest and highest of the finite values (n,) of a slow channel, less what its white noise adds to both: the noise
    of an ammeter is no change of the current. None without values.

    The second differences of white noise have sqrt(6) times its standard deviation; steps and slow changes are seldom
    in their median.
    """
    values = values[np.isfinite(values)]
    if not values.size:
        return None
    noise = float(np.median(np.abs(np.diff(values, 2)))) / (0.6745 * 6.0**0.5) if values.size > 2 else 0.0
    low, high = float(values.min()) + _PEAK * noise, float(values.max()) - _PEAK * noise
    return (low, high) if low <= high else (float(np.median(values)),) * 2


def force_at_rest(model: DamperModel, measurement: Measurement) -> float:
    """N, the model's force at rest in the middle of a recording's stroke."""
    return _forces_at_rest(model, measurement)[0]


def _forces_at_rest(model: DamperModel, measurement: Measurement) -> tuple[float, float]:
    """N, the model's force at rest in the middle of the stroke: the whole, and without what acts beside the oil."""
    kinematics = measurement.kinematics
    block = kinematics.block[:, :1].copy()
    block[[V, A, DT]] = 0.0
    block[X] = np.median(kinematics.displacement[measurement.judged])
    rigid = without_compliances(model)
    force, parts = rigid.stream().contributions(block)
    through = [not entry.effect.beside_oil for entry in walk(rigid.effects)]
    return float(np.nan_to_num(force[0])), float(np.nan_to_num(parts[through]).sum())


def _identified(model: DamperModel | None) -> frozenset[str]:
    """Phenomena of which the model has parameters that are not fixed."""
    if model is None:
        return frozenset()
    phenomena = [element.effect.phenomenon for element in walk(model.effects)]
    return frozenset(phenomena[slot.entry] for slot in model.slots if not slot.fixed)
