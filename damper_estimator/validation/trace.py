"""A model run over measurements: measured and modelled force in band, and the judged samples of several as one pool."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.signals.cycles import reversals
from damper_estimator.signals.kinematics import WARM_UP, Kinematics


@dataclass(frozen=True)
class Trace:
    """One recording and the forces of a model run over it.

    Attributes:
        measurement: the recording.
        measured, modelled: (n,) N in band; measured is the damper's force.
        judged: (n,) bool, samples that count.
        lost: samples where the model's force was not finite.
    """

    measurement: Measurement
    measured: np.ndarray
    modelled: np.ndarray
    judged: np.ndarray
    lost: int

    @property
    def residual(self) -> np.ndarray:
        """(n,) N, modelled - measured."""
        return self.modelled - self.measured

    @property
    def time(self) -> np.ndarray:
        """(n,) s since the first sample of the recording."""
        return self.measurement.kinematics.time

    @cached_property
    def since_reversal(self) -> np.ndarray:
        """(n,) s since the velocity last changed its sign; NaN before the first time."""
        return _since_reversal(self.measurement)

    @cached_property
    def half_cycles(self) -> tuple[np.ndarray, np.ndarray]:
        """(n,) Hz and (n,) m, frequency and amplitude of the half cycle that each sample is in; NaN outside of any."""
        return _half_cycles(self.measurement.kinematics)


def trace(model: DamperModel, measurement: Measurement) -> Trace:
    """Runs a model over a measurement.

    Raises:
        InputError: where no sample can be judged.
    """
    force = model.force(measurement.kinematics.block)
    finite = np.isfinite(force)
    judged = measurement.judged & _settled(finite, measurement)
    if not judged.any():
        where = f"{measurement.recording}: damper {measurement.damper}"
        if measurement.judged.any():
            raise InputError(
                f"{where}: model {model.name} returns no finite force; provide the channels and ranges that it needs"
            )
        raise InputError(
            f"{where}: nothing to judge; wants more than {WARM_UP:g} s without a gap in which force and "
            "displacement were recorded"
        )
    measured = measurement.in_band(measurement.force)
    modelled = measurement.in_band(np.where(finite, force, 0.0))
    return Trace(measurement, measured, modelled, judged, int(np.count_nonzero(~finite)))


def _settled(finite: np.ndarray, measurement: Measurement) -> np.ndarray:
    """Samples whose band-limited force no hole in the model's force has touched."""
    settled = finite.copy()
    stamp, reach = measurement.kinematics.stamp, round(WARM_UP * 1e9)
    for i in np.flatnonzero(np.diff(finite.astype(np.int8), prepend=1, append=1)):
        # One edge of a hole: both sides ring.
        at = stamp[min(i, stamp.size - 1)]
        settled[np.searchsorted(stamp, at - reach) : np.searchsorted(stamp, at + reach)] = False
    return settled


def _since_reversal(measurement: Measurement) -> np.ndarray:
    kinematics = measurement.kinematics
    since = np.full(len(kinematics), np.nan)
    # Small motion around standstill is no reversal: the speed must reach a twentieth of its rms on both sides.
    least = 0.05 * float(np.sqrt(np.mean(kinematics.velocity**2)))
    if least <= 0.0:
        return since
    for part in kinematics.stretches():
        velocity, time = kinematics.velocity[part], kinematics.time[part]
        crossings = np.flatnonzero(np.diff(np.sign(velocity)) != 0) + 1
        moving = np.flatnonzero(np.abs(velocity) > least)
        turned = moving[1:][np.diff(np.sign(velocity[moving])) != 0]
        if not turned.size:
            continue
        reversals = np.unique(crossings[np.searchsorted(crossings, turned, side="right") - 1])
        last = np.searchsorted(reversals, np.arange(time.size), side="right") - 1
        since[part] = np.where(last >= 0, time - time[reversals[np.maximum(last, 0)]], np.nan)
    return since


def _half_cycles(kinematics: Kinematics) -> tuple[np.ndarray, np.ndarray]:
    frequency, amplitude = np.full((2, len(kinematics)), np.nan)
    for part in kinematics.stretches():
        at = reversals(kinematics, part)
        for first, last in zip(at[:-1].tolist(), at[1:].tolist(), strict=True):
            frequency[first:last] = 0.5 / (kinematics.time[last] - kinematics.time[first])
            amplitude[first:last] = 0.5 * abs(kinematics.displacement[last] - kinematics.displacement[first])
    return frequency, amplitude


@dataclass(frozen=True)
class Pool:
    """The judged samples of several traces one after the other; all arrays (n,), SI.

    Attributes:
        recording: index of the trace that each sample comes from.
        elapsed: s since the first sample of that recording.
        since_reversal: s, NaN before the first.
        frequency, amplitude: Hz and m, of the half cycle that the sample is in; NaN outside of any.
        slow: N, the part of the error that does not depend on the operation: the gauge's zero and its drift.
        band: Hz.
    """

    measured: np.ndarray
    modelled: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    command: np.ndarray
    temperature: np.ndarray
    dt: np.ndarray
    elapsed: np.ndarray
    since_reversal: np.ndarray
    frequency: np.ndarray
    amplitude: np.ndarray
    slow: np.ndarray
    recording: np.ndarray
    band: float

    @property
    def residual(self) -> np.ndarray:
        """(n,) N, modelled - measured."""
        return self.modelled - self.measured

    @property
    def structure(self) -> np.ndarray:
        """(n,) N, the residual less zero and drift: the part that depends on the operation."""
        return self.residual - self.slow


def pool(traces: Sequence[Trace], slow: Sequence[np.ndarray] | None = None) -> Pool:
    """Judged samples of all traces; ``slow`` holds (n,) N for each, zero where it is None."""
    slow_parts = [np.zeros(t.time.size) for t in traces] if slow is None else slow

    def gathered(column) -> np.ndarray:
        return np.concatenate([np.asarray(column(t))[t.judged] for t in traces])

    return Pool(
        measured=gathered(lambda t: t.measured),
        modelled=gathered(lambda t: t.modelled),
        displacement=gathered(lambda t: t.measurement.kinematics.displacement),
        velocity=gathered(lambda t: t.measurement.kinematics.velocity),
        acceleration=gathered(lambda t: t.measurement.kinematics.acceleration),
        command=gathered(lambda t: t.measurement.kinematics.command),
        temperature=gathered(lambda t: t.measurement.kinematics.temperature),
        dt=gathered(lambda t: t.measurement.kinematics.dt),
        elapsed=gathered(lambda t: t.time - t.time[0]),
        since_reversal=gathered(lambda t: t.since_reversal),
        frequency=gathered(lambda t: t.half_cycles[0]),
        amplitude=gathered(lambda t: t.half_cycles[1]),
        slow=np.concatenate([values[t.judged] for t, values in zip(traces, slow_parts, strict=True)]),
        recording=np.repeat(np.arange(len(traces)), [int(t.judged.sum()) for t in traces]),
        band=traces[0].measurement.band,
    )
