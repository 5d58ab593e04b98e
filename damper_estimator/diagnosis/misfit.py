"""What a model already got wrong when it was identified, without assuming a form, kept in its record of the fit.

A model that lacks the oil's compressibility errs on every recording in the same way. Without knowing that, whatever
changes later is looked for beneath an error that is not new. The joint solution of the atlas's tests on the recordings
of the identification predicts the old error on new ones:

    F_measured - F_model ~ sum_k c_k term_k(x, v, a, F_model)

It is kept only if it predicts the last part of those recordings from the first, and it never becomes part of the model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from damper_estimator.diagnosis import error_profile
from damper_estimator.diagnosis.atlas_terms import TESTS, Columns, View, view_of
from damper_estimator.diagnosis.diagnosis_data import dynamic_force, ranges_of, targets, unweighted, weights
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.effects.trial import Ranges
from damper_estimator.identification import rows_of, usable
from damper_estimator.identification.fit_record import recorded
from damper_estimator.identification.rows import DRIFTING, Rows, excerpts
from damper_estimator.model import DamperModel
from damper_estimator.numerics import normal_equations
from damper_estimator.signals import Measurement

_KEPT = ("curve", "memory", "travel", "shift", "series", "lags", "history")
_FORMER = {"friction step": "memory"}  # names of tests in files of earlier versions
_FIRST = 0.6  # of each recording
_DIGITS = 5
_SAMPLES = 100_000  # of long recordings, in excerpts
_EXCERPT = 20.0  # s
_CHANGES = 5.0  # range of ln g: a change that matters multiplies the squared error by 1 to 150
_ALIKE = 1.2  # times: errors that are called as large as each other
KEY = "misfit"
IMPROVED = "improved"  # whether `improve` ended because it could name nothing in what the model leaves
ZERO = "zero"  # N, mean error at the identification, with the signal map's offset of the gauge taken off


@dataclass(frozen=True)
class Misfit:
    """The prediction of a model's error.

    Attributes:
        ranges: that lay the columns of the tests out.
        coefficients: of the tests, N per unit of their columns.
        left: what it leaves on recordings that it was not computed from, share of the force's rms; NaN in files of
            earlier versions.
    """

    ranges: Ranges
    coefficients: Mapping[str, tuple[float, ...]]
    left: float = float("nan")

    def leaves_more(self, left: float) -> bool:
        """Whether an error, share of the force's rms, is clearly larger than what the prediction always left."""
        return is_larger(left, self.left)

    def force(self, model: DamperModel, measurement: Measurement) -> np.ndarray:
        """(n,) N, by how much the measured force is predicted to differ from the model's."""
        view = view_of(model, measurement, self.ranges)
        total = np.zeros(len(measurement.kinematics))
        for test in _tests():
            if test.name in self.coefficients:
                for column, coefficient in zip(test.columns(view), self.coefficients[test.name], strict=True):
                    total += coefficient * column
        return total

    def record(self) -> dict[str, object]:
        """For the model file."""
        return {
            "compression": _rounded(self.ranges.compression),
            "extension": _rounded(self.ranges.extension),
            "speed": _rounded(self.ranges.speed),
            "left": _rounded(self.left),
            "newtons": {name: [_rounded(c) for c in values] for name, values in self.coefficients.items()},
        }


def misfit_of(record: Mapping[str, Any]) -> Misfit | None:
    """What a model's record of its fit holds; None where it holds nothing of the kind, or something else."""
    kept = record.get(KEY)
    try:
        given = {str(name): tuple(float(c) for c in values) for name, values in kept["newtons"].items()}
        coefficients = {_FORMER.get(name, name): values for name, values in given.items()}
        ranges = _ranges(*(float(kept[name]) for name in ("compression", "extension", "speed")))
        left = float(kept.get("left", "nan"))
    except (TypeError, KeyError, ValueError, AttributeError):
        return None
    if any(len(values) != _sizes().get(name) for name, values in coefficients.items()):
        return None
    return Misfit(ranges, coefficients, left)


@dataclass(frozen=True)
class UsualError:
    """The error when a model was identified, where the error now is not new.

    Attributes:
        error_n: then, N.
        share, share_now: of the force then, and now.
        factor: by which a larger share is usual on this motion, `motion_factor`.
    """

    error_n: float
    share: float
    share_now: float
    factor: float = 1.0

    @property
    def words(self) -> str:
        """What the error is, compared with that of the identification."""
        if not np.isfinite(self.share):
            return "is what the model has always got wrong"
        usual = self.factor * self.share
        if is_larger(self.share_now, usual):
            # It is small, or the known error accounts for it: otherwise it would be analysed.
            small = f"though still below {100.0 * limits().notable:.2g} % of the force"
            reason = small if self.share_now < limits().notable else "by what the model has always got wrong"
            compared = f"larger, {reason}, than"
        elif self.share_now > _ALIKE * usual:
            compared = "larger, but not by more than errors usually differ, than"
        elif self.share_now > _ALIKE * self.share:
            compared = "larger, as it has always been at such speeds and frequencies, than"
        else:
            compared = "smaller than" if _ALIKE * self.share_now < self.share else "as large as"
        return f"is {compared} when the model was identified ({self.error_n:.3g} N, {100.0 * self.share:.2g} %)"


def is_larger(now: float, then: float) -> bool:
    """Whether an error is clearly larger than an earlier one; true if the earlier one is unknown (NaN)."""
    return not now**2 <= limits().growth * then**2


def error_then(model: DamperModel) -> tuple[float, float]:
    """Error of a model when it was identified, N and share of the force's rms; NaN where it is unknown."""
    then_n, force_n = recorded(model, "residual_stddev"), recorded(model, "force_rms")
    return then_n, then_n / force_n if force_n else float("nan")


def motion_factor(model: DamperModel, rows: Sequence[Rows]) -> float:
    """By how much larger a share of the force the usual error is on these rows than at the identification; at least 1,
    and 1 where the model's record does not say.
    """
    profile, (_, then) = error_profile.recorded_profile(model.fit), error_then(model)
    if profile is None or not then > 0.0:
        return 1.0
    return max(profile.expected(rows) / max(dynamic_force(rows), 1e-300) / then, 1.0)


def has_grown(model: DamperModel, error: float, if_unknown: bool = True) -> bool:
    """Whether a model's error, share of the force's rms, is clearly larger than when it was identified."""
    _, then = error_then(model)
    return is_larger(error, then) if np.isfinite(then) else if_unknown


def usual_bound(model: DamperModel) -> float:
    """Share of the force below which an error that has not grown since the identification is left alone. What `improve`
    left there is nothing that it could name, however large it is.
    """
    return float("inf") if model.fit.get(IMPROVED) is True else limits().usual


def usual_share(then: float, now: float) -> float:
    """Of the squared error now, from the errors when a model was identified and now, shares of the force's rms; 0 if
    the error then is unknown.
    """
    return min(then / max(now, 1e-12), 1.0) ** 2 if then > 0.0 else 0.0


def usual_error(model: DamperModel, share_now: float, rows: Sequence[Rows]) -> UsualError:
    """Of a model whose error, share of the force's rms, is not new on these rows; NaN where its identification is
    unknown.
    """
    return UsualError(*error_then(model), share_now, motion_factor(model, rows))


def probability_of_change(model: DamperModel, error: float) -> float:
    """That something has changed since a model was identified, from its error now, share of the force's rms; 1 if the
    error then is unknown.

    Without a change the ratio g of the squared errors is log-normal about its usual value; a change of any size makes
    ln g uniform over some range. Both are equally probable beforehand:

        P = 1 / (1 + range / (s sqrt(2 pi)) exp(-(ln g / g_0)^2 / (2 s^2)))      for g > g_0
    """
    _, then = error_then(model)
    if not then > 0.0:
        return 1.0
    spread = np.log(limits().growth)
    above = max(np.log(max(error, 1e-12) ** 2 / then**2 / limits().usual_growth), 0.0)
    unchanged = _CHANGES / (spread * np.sqrt(2.0 * np.pi)) * np.exp(-0.5 * (above / spread) ** 2)
    return float(1.0 / (1.0 + unchanged))


def with_misfit(model: DamperModel, measurements: Sequence[Measurement]) -> DamperModel:
    """The model with what it gets wrong on the recordings of its identification in its record."""
    record = {name: value for name, value in model.fit.items() if name not in (KEY, ZERO, error_profile.KEY)}
    rows = _excerpts(model, measurements)
    found = _found_misfit(model, rows) if rows else None
    judged = [m for m in measurements if m.force is not None and m.judged.any()]
    zeros = [mean_error(model, m, found) - m.signals.force.offset for m in judged]
    zero = float(np.average(zeros, weights=[m.judged.sum() for m in judged])) if zeros else float("nan")
    known = {ZERO: _rounded(zero)} if np.isfinite(zero) else {}
    if rows:
        known[error_profile.KEY] = error_profile.profile_of(model, rows).record()
    return replace(model, fit=record | known | ({KEY: found.record()} if found else {}))


def mean_error(model: DamperModel, measurement: Measurement, known: Misfit | None = None) -> float:
    """Measured less modelled force, less what the model is known to get wrong, N on average."""
    modelled = model.force(measurement.kinematics.block)
    predicted = known.force(model, measurement) if known is not None else 0.0
    return float(np.mean((measurement.force - np.nan_to_num(modelled) - predicted)[measurement.judged]))


def _excerpts(model: DamperModel, measurements: Sequence[Measurement]) -> list[Rows]:
    """The rows of recordings, of long ones in excerpts."""
    whole = [m.part(part.start, part.stop) for m in measurements for part in usable(model, m)]
    total = sum(len(m.kinematics) for m in whole)
    parts = [
        m.part(p.start, p.stop)
        for m in whole
        for p in excerpts(m, max(round(_SAMPLES * len(m.kinematics) / total), 1), _EXCERPT)
    ]
    rows = [rows_of(m, weights(model, m), zero=DRIFTING) for m in parts]
    return [part for part in rows if part.picks.size > 100]


def _found_misfit(model: DamperModel, rows: Sequence[Rows]) -> Misfit | None:
    """What a model gets wrong on recordings, where that predicts their last part from the first; else None."""
    ranges = ranges_of([part.measurement for part in rows])
    first = [part.part(slice(0, round(_FIRST * len(part.measurement.kinematics)))) for part in rows]
    last = [part.part(slice(round(_FIRST * len(part.measurement.kinematics)), None)) for part in rows]
    columns, missing = _system(model, first, ranges)
    solution = _solved(columns, missing, first)
    columns, missing = _system(model, last, ranges)
    left = missing - columns @ solution
    if float(np.sum(left**2)) > (1.0 - limits().predicts) * float(np.sum(missing**2)):
        return None
    share = unweighted(last, left) / max(unweighted(last, targets(last)), 1e-300)
    columns, missing = _system(model, rows, ranges)
    solution = _solved(columns, missing, rows)
    view = view_of(model, rows[0].measurement, ranges)
    sizes = [len(test.columns(view)) for test in _tests()]
    each = np.split(solution, np.cumsum(sizes)[:-1])
    coefficients = {test.name: tuple(explained.tolist()) for test, explained in zip(_tests(), each, strict=True)}
    return Misfit(ranges, coefficients, share)


def _tests():
    return [test for test in TESTS if test.name in _KEPT]


@cache
def _sizes() -> dict[str, int]:
    """Number of columns of each test."""
    nothing = np.zeros(2)
    view = View(nothing, nothing, nothing, nothing, None, None, nothing, nothing, nothing, _ranges(-1.0, 1.0, 1.0))
    return {test.name: len(test.columns(view) or ()) for test in _tests()}


def _system(model: DamperModel, rows: Sequence[Rows], ranges: Ranges) -> tuple[np.ndarray, np.ndarray]:
    """(r, k) columns of all tests and (r,) the force that the model lacks."""
    columns, missing = [], []
    for part in rows:
        view: View = view_of(model, part.measurement, ranges)
        terms: Columns = [column for test in _tests() for column in test.columns(view)]
        columns.append(part.of_columns(terms))
        missing.append(part.target - part.of(np.nan_to_num(model.force(part.measurement.kinematics.block))))
    return np.concatenate(columns), np.concatenate(missing)


def _solved(columns: np.ndarray, missing: np.ndarray, rows: Sequence[Rows]) -> np.ndarray:
    """(k,) coefficients; each column's share is limited to the order of the force."""
    scale = np.sqrt(np.mean(columns**2, axis=0))
    scale = np.where(scale > 1e-9 * scale.max(), scale, np.inf)
    normal, right = normal_equations(columns / scale, missing)
    power = max(float(np.mean(targets(rows) ** 2)), 1e-300)
    normal[np.diag_indices_from(normal)] += float(np.mean(missing**2)) / power * missing.size**0.5 + 1e-12
    return np.linalg.solve(normal, right) / scale


def _ranges(compression: float, extension: float, speed: float) -> Ranges:
    return Ranges(compression, extension, speed, acceleration=1.0, force=1.0, seconds=1.0)


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
