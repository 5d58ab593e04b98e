"""Mean loops: cycles of one frequency, stroke and command, averaged over their phase."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from damper_estimator.signals import Measurement
from damper_estimator.signals.cycles import Cycle, find_cycles

PHASES = 360
SINE_LIKE = 0.06  # departure from the first harmonic up to which a cycle belongs to a steady sine test
NEARLY_SINE = 0.20  # up to which a single cycle of a random recording is used as one
FEWEST_SAMPLES = 16  # per cycle; fewer cannot show a knee
FEWEST_STEADY, FEWEST_RANDOM = 2, 6  # cycles in a mean
_FREQUENCY, _AMPLITUDE, _COMMAND = 0.06, 0.20, 0.04  # maximum distance of a cycle from the mean of its operating point
_WIDER = 3.0  # factor on these for single cycles of a random motion


@dataclass(frozen=True)
class Loop:
    """The mean cycle at one operating point; arrays (360,), phase 0 at the reversal into extension.

    Attributes:
        frequency, amplitude: Hz, m.
        command, pressure: means; NaN if unknown.
        displacement, velocity, acceleration, force: SI; displacement from the middle of the stroke.
        spread: N, standard deviation among the cycles.
        middle: m, middle of the stroke in the displacement of the recording.
        cycles: number averaged.
        steady: whether they are consecutive as in a sine test; otherwise they are from a random motion.
        recordings: paths of the bags.
    """

    frequency: float
    amplitude: float
    command: float
    pressure: float
    displacement: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray
    spread: np.ndarray
    middle: float
    cycles: int
    steady: bool
    recordings: tuple[str, ...]

    @cached_property
    def peak_velocity(self) -> float:
        """m/s, the larger of both directions."""
        return float(np.abs(self.velocity).max())

    def less(self, other: "Loop") -> "Loop":
        """This loop with the other's force at the same phase subtracted; the motion is unchanged."""
        return replace(
            self,
            force=self.force - other.force,
            spread=np.hypot(self.spread, other.spread),
            cycles=min(self.cycles, other.cycles),
            steady=self.steady and other.steady,
            recordings=tuple(dict.fromkeys((*self.recordings, *other.recordings))),
        )


@dataclass(frozen=True)
class _Sample:
    """One cycle of one recording."""

    measurement: Measurement
    cycle: Cycle
    command: float
    pressure: float
    follows: bool  # whether the preceding cycle was similar


def mean_loops(measurements: Sequence[Measurement], forces: Sequence[np.ndarray]) -> tuple[list[Loop], list[Loop]]:
    """Mean loops of the steady sine passages, and of single cycles picked from random motion; both by rising frequency.

    The first cycle of each steady passage is left out as transient.

    Args:
        measurements: of one damper.
        forces: (n,) N for each of them, the force to be averaged (the measured one, or a remainder of it).
    """
    samples = [sample for m in measurements for sample in _samples(m)]
    force_of = {id(m): force for m, force in zip(measurements, forces, strict=True)}
    largest = max((abs(s.command) for s in samples if np.isfinite(s.command)), default=0.0)
    sines = [s for s in samples if s.cycle.departure <= SINE_LIKE]
    steady, leftover = [], [s for s in samples if SINE_LIKE < s.cycle.departure <= NEARLY_SINE]
    for group in _groups(sines, largest, 1.0):
        settled = [s for s in group if s.follows]
        if len(settled) >= FEWEST_STEADY:
            steady.append(_mean(settled, force_of, True))
        else:
            leftover += group
    single = [_mean(g, force_of, False) for g in _groups(leftover, largest, _WIDER) if len(g) >= FEWEST_RANDOM]
    return sorted(steady, key=_order), sorted(single, key=_order)


def _order(loop: Loop) -> tuple[float, float, float]:
    # Equal motions are sorted by command.
    return (
        round(np.log(loop.frequency) / _FREQUENCY),
        round(np.log(loop.amplitude) / _AMPLITUDE),
        np.nan_to_num(loop.command),
    )


def _samples(measurement: Measurement) -> list[_Sample]:
    kinematics = measurement.kinematics
    samples: list[_Sample] = []
    before: Cycle | None = None
    for cycle in find_cycles(kinematics, measurement.judged):
        if cycle.last - cycle.first >= FEWEST_SAMPLES:
            inside = slice(cycle.first, cycle.last)
            command, pressure = (_constant(row[inside]) for row in (kinematics.command, kinematics.block[7]))
            follows = before is not None and abs(before.end - cycle.start) < 1e-6 and _alike(before, cycle)
            samples.append(_Sample(measurement, cycle, command, pressure, follows))
        before = cycle
    return samples


def _alike(a: Cycle, b: Cycle) -> bool:
    return (
        abs(np.log(a.frequency / b.frequency)) < _FREQUENCY
        and abs(np.log(a.amplitude / b.amplitude)) < _AMPLITUDE
        and a.departure <= SINE_LIKE
    )


def _constant(values: np.ndarray) -> float:
    """Mean of a slow channel; NaN if any value is missing."""
    return float(values.mean()) if np.isfinite(values).all() else float("nan")


def _groups(samples: Sequence[_Sample], largest: float, wider: float) -> list[list[_Sample]]:
    """Cycles of one frequency, amplitude and command together; each cycle joins the nearest group that admits it."""
    groups: list[list[_Sample]] = []
    means: list[np.ndarray] = []
    width = np.array([wider * _FREQUENCY, wider * _AMPLITUDE, max(_COMMAND * largest, 1e-9)])
    for sample in samples:
        place = np.array(
            [np.log(sample.cycle.frequency), np.log(sample.cycle.amplitude), np.nan_to_num(sample.command, nan=-1e9)]
        )
        distance = [float(np.max(np.abs(place - mean) / width)) for mean in means]
        nearest = int(np.argmin(distance)) if distance else -1
        if nearest >= 0 and distance[nearest] <= 1.0:
            groups[nearest].append(sample)
            means[nearest] += (place - means[nearest]) / len(groups[nearest])
        else:
            groups.append([sample])
            means.append(place)
    return groups


def _mean(group: Sequence[_Sample], force_of: dict[int, np.ndarray], steady: bool) -> Loop:
    phase = np.arange(PHASES) / PHASES
    columns = np.empty((4, len(group), PHASES))
    for i, sample in enumerate(group):
        k, cycle = sample.measurement.kinematics, sample.cycle
        at = cycle.start + phase * (cycle.end - cycle.start)
        near = slice(max(cycle.first - 2, 0), cycle.last + 2)
        signals = (k.displacement - cycle.middle, k.velocity, k.acceleration, force_of[id(sample.measurement)])
        for column, signal in zip(columns, signals, strict=True):
            column[i] = np.interp(at, k.time[near], signal[near])
    x, v, a, f = columns.mean(axis=1)
    cycles = [s.cycle for s in group]
    return Loop(
        frequency=float(np.mean([c.frequency for c in cycles])),
        amplitude=float(np.mean([c.amplitude for c in cycles])),
        command=float(np.mean([s.command for s in group])),
        pressure=float(np.mean([s.pressure for s in group])),
        displacement=x,
        velocity=v,
        acceleration=a,
        force=f,
        spread=columns[3].std(axis=0),
        middle=float(np.mean([c.middle for c in cycles])),
        cycles=len(group),
        steady=steady,
        recordings=tuple(dict.fromkeys(s.measurement.recording for s in group)),
    )
