"""Groups of cycles by velocity and frequency: LVLF, LVHF, HVLF, HVHF, with limits from the recordings' ranges.

    high velocity:  peak velocity > 0.4 of the largest           high frequency:  f > sqrt(f_min f_max)

The factor and the mean give the groups of Gao et al., Table 1 (1.5 and 12 Hz, 0.1 to 1.2 m/s), whose objectives are
means over such groups. If the frequencies, or the peak velocities, span less than a factor of two, that letter is left
out.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.signals.cycles import Cycle, find_cycles
from damper_estimator.signals.measurement import Measurement

HIGH_VELOCITY = 0.4  # of the largest peak velocity
LEAST_SPAN = 2.0  # largest over smallest, below which a quantity is not divided
_TAIL = 0.01  # share of the time in cycles at either end that does not set a range


@dataclass(frozen=True)
class GroupLimits:
    """Limits between low and high; infinite if there is only one group.

    Attributes:
        velocity: m/s, of a cycle's peak velocity.
        frequency: Hz.
    """

    velocity: float
    frequency: float

    def group(self, cycle: Cycle) -> str:
        """Name of a cycle's group, such as ``LVHF``; ``all`` if nothing is divided."""
        velocity = "" if np.isinf(self.velocity) else "HV" if cycle.peak_velocity > self.velocity else "LV"
        frequency = "" if np.isinf(self.frequency) else "HF" if cycle.frequency > self.frequency else "LF"
        return velocity + frequency or "all"


def group_limits(cycles: Iterable[Cycle]) -> GroupLimits:
    """Limits from the ranges that cycles of all recordings cover together, rare ones at the ends left out."""
    known = list(cycles)
    if not known:
        return GroupLimits(np.inf, np.inf)
    seconds = np.array([cycle.end - cycle.start for cycle in known])
    slowest, fastest = _range(np.array([cycle.peak_velocity for cycle in known]), seconds)
    low, high = _range(np.array([cycle.frequency for cycle in known]), seconds)
    return GroupLimits(
        velocity=HIGH_VELOCITY * fastest if fastest >= LEAST_SPAN * slowest else np.inf,
        frequency=float(np.sqrt(low * high)) if high >= LEAST_SPAN * low else np.inf,
    )


def _range(values: np.ndarray, seconds: np.ndarray) -> tuple[float, float]:
    order = np.argsort(values)
    share = np.cumsum(seconds[order]) / seconds.sum()
    low, high = np.searchsorted(share, [_TAIL, 1.0 - _TAIL])
    return float(values[order[min(low, values.size - 1)]]), float(values[order[min(high, values.size - 1)]])


@dataclass(frozen=True)
class Grouped:
    """The groups of several recordings.

    Attributes:
        limits: of the groups.
        names: in order LVLF, LVHF, HVLF, HVHF.
        labels: for each recording (n,) int, the index of each sample's group in ``names``; -1 outside of whole judged
            cycles.
        cycles: for each recording its whole judged cycles.
    """

    limits: GroupLimits
    names: tuple[str, ...]
    labels: tuple[np.ndarray, ...]
    cycles: tuple[tuple[Cycle, ...], ...]


_ORDER = ("LVLF", "LVHF", "HVLF", "HVHF", "LV", "HV", "LF", "HF", "all")


def group_names(found: Iterable[str]) -> tuple[str, ...]:
    """The found names, each once and in order."""
    present = set(found)
    return tuple(name for name in _ORDER if name in present)


def group_cycles(
    measurements: Sequence[Measurement], limits: GroupLimits | None = None, names: Sequence[str] = ()
) -> Grouped:
    """Every whole judged cycle of every recording in its group, by its dominant frequency and peak velocity.

    Args:
        measurements: of one damper.
        limits: None derives them from these recordings.
        names: of the groups, if other recordings have more than these; in the order of ``group_names``.
    """
    cycles = tuple(tuple(find_cycles(m.kinematics, m.judged)) for m in measurements)
    chosen = group_limits(cycle for of_recording in cycles for cycle in of_recording) if limits is None else limits
    names = tuple(names) or group_names(chosen.group(cycle) for of_recording in cycles for cycle in of_recording)
    labels = []
    for measurement, of_recording in zip(measurements, cycles, strict=True):
        label = np.full(len(measurement.kinematics), -1)
        for cycle in of_recording:
            label[cycle.first : cycle.last] = names.index(chosen.group(cycle))
        labels.append(label)
    return Grouped(chosen, names, tuple(labels), cycles)
