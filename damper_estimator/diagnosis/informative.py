"""Chooses the informative stretches of long recordings.

An hour of driving repeats itself. Effects are fitted to and judged on a few minutes of it that hold nearly all the
information; the errors of models remain those of the whole. The stretches are chosen by their motion and slow channels
alone, one after the other, each for the largest gain of

    log det (R + sum_s C_s' C_s)

with the columns C_s (n, k) of a form-free regression on stretch s: hat functions of velocity, alone and times position,
command, temperature, time and acceleration; hat functions of position and of time; plays over the displacement. R is a
small ridge.
This is the greedy D-optimal design (V. V. Fedorov, Theory of Optimal Experiments, 1972).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.identification.rows import SAMPLES_PER_BAND
from damper_estimator.numerics import COARSE_SHARES, hats, speed_knots
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import V, X
from damper_estimator.validation.form_free import FormFree, unfitted

LONGEST = 360.0  # s, recordings together; longer ones are not used whole
CHOSEN = 240.0  # s of them
_STRETCH = 10.0  # s
_PLACES = 9  # knots over the driven stroke
_TIMES = 5  # knots over the time, for what drifts
_RIDGE = 0.1  # of the information that a stretch holds on average


@dataclass(frozen=True)
class Stretch:
    """A stretch that was used of a recording.

    Attributes:
        recording: path.
        use: ``fit`` or ``unseen``.
        start, stop: s since the start of the recording.
    """

    recording: str
    use: str
    start: float
    stop: float


def stretches_used(use: str, whole: Sequence[Measurement], part: Sequence[Measurement]) -> tuple[Stretch, ...]:
    """What ``informative`` kept of recordings; empty if it kept all."""
    if len(part) == len(whole) and all(a is b for a, b in zip(part, whole, strict=True)):
        return ()
    return tuple(
        Stretch(m.recording, use, float(m.kinematics.time[p.start]), float(m.kinematics.time[p.stop - 1]))
        for m in part
        for p in m.kinematics.stretches()
    )


def informative(measurements: Sequence[Measurement]) -> tuple[Measurement, ...]:
    """The recordings themselves, or about ``CHOSEN`` seconds of them if they last longer than ``LONGEST`` together.

    Each remains one recording, now with gaps; one of which no stretch was chosen is left out.
    """
    if sum(float(m.kinematics.dt.sum()) for m in measurements) <= LONGEST:
        return tuple(measurements)
    stretches = [(i, part) for i, m in enumerate(measurements) for part in _stretches(m)]
    chosen = _chosen(np.array(list(_information(measurements, stretches))), round(CHOSEN / _STRETCH))
    parts: dict[int, list[slice]] = {}
    for i, part in (stretches[k] for k in sorted(chosen)):
        before = parts.setdefault(i, [])
        if before and before[-1].stop == part.start:  # neighbours are one stretch, with one warm-up
            before[-1] = slice(before[-1].start, part.stop)
        else:
            before.append(part)
    return tuple(measurements[i].parts(kept) for i, kept in parts.items())


def _stretches(measurement: Measurement) -> Iterator[slice]:
    """A recording in pieces of about ``_STRETCH`` seconds; the last one takes the rest."""
    each = max(round(_STRETCH * measurement.kinematics.rate), 2)
    count = max(len(measurement.kinematics) // each, 1)
    for k in range(count):
        yield slice(k * each, (k + 1) * each if k < count - 1 else len(measurement.kinematics))


def _information(measurements: Sequence[Measurement], stretches: Sequence[tuple[int, slice]]) -> Iterator[np.ndarray]:
    """C' C (k, k) of every stretch."""
    shape = unfitted(measurements)
    strokes = [m.kinematics.displacement[m.judged] for m in measurements]
    places = np.linspace(min(x.min() for x in strokes if x.size), max(x.max() for x in strokes if x.size), _PLACES)
    first = min(int(m.kinematics.stamp[0]) for m in measurements)
    last = max(int(m.kinematics.stamp[-1]) for m in measurements)
    for i, part in stretches:
        m = measurements[i]
        stride = max(int(m.kinematics.rate / (SAMPLES_PER_BAND * m.band)), 1) if m.band > 0.0 else 1
        thin = slice(part.start, part.stop, stride)
        time = (m.kinematics.stamp[thin] - first) / max(last - first, 1)
        columns = _columns(shape, np.ascontiguousarray(m.kinematics.block[:, thin]), places, time)[:, m.judged[thin]]
        yield columns @ columns.T


def _columns(shape: FormFree, block: np.ndarray, places: np.ndarray, time: np.ndarray) -> np.ndarray:
    """(k, n) columns of the regression on a sample block, with those of position and time."""
    coarse = hats(block[V], speed_knots(shape.speed, COARSE_SHARES))
    columns = [column for column, _ in shape.columns(block)]
    drift = hats(time, np.linspace(0.0, 1.0, _TIMES))
    return np.stack([*columns, *hats(block[X], places), *drift, *(time * column for column in coarse)])


def _chosen(information: np.ndarray, count: int) -> list[int]:
    """Which of the matrices (s, k, k) to take, one by one, each for the largest log det of the sum."""
    size = np.sqrt(np.maximum(np.einsum("skk->k", information), 1e-300))
    shares = information / size[:, None] / size[None, :]
    total = _RIDGE / len(shares) * np.eye(size.size)
    left = list(range(len(shares)))
    chosen: list[int] = []
    while left and len(chosen) < count:
        gains = [np.linalg.slogdet(total + shares[k])[1] for k in left]
        best = left.pop(int(np.argmax(gains)))
        total = total + shares[best]
        chosen.append(best)
    return chosen
