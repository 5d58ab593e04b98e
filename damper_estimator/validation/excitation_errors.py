"""Errors by excitation: over frequency, and by groups of velocity and frequency."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from damper_estimator.signals.grouping import GroupLimits, group_cycles
from damper_estimator.validation.trace import Trace

_OCTAVE_SHARE = 6  # cycles within a sixth of an octave count as one excitation frequency


@dataclass(frozen=True)
class FrequencyError:
    """rms(e) / rms(F) of the cycles near one frequency; HIS paper, eq. (9).

    Attributes:
        frequency_hz: mean of the cycles.
        relative_rms: 1.
        rmse_n: N.
        cycles: number of cycles.
    """

    frequency_hz: float
    relative_rms: float
    rmse_n: float
    cycles: int


@dataclass(frozen=True)
class GroupError:
    """The error of one group of excitations.

    Attributes:
        name: LVLF, LVHF, HVLF, HVHF, or the user's.
        recordings: number of recordings in it.
        cycles: whole cycles in it; 0 for a group of whole recordings.
        samples: judged samples.
        peak_velocity_m_s, frequency_hz: smallest and largest of its cycles.
        rmse_n, relative_rms: over its samples.
        mean_square_n2: mean over its recordings of their mean square error, the objective of Gao et al., eq. (9),
            before it is divided by that of the starting point.
    """

    name: str
    recordings: int
    cycles: int
    samples: int
    peak_velocity_m_s: tuple[float, float]
    frequency_hz: tuple[float, float]
    rmse_n: float
    relative_rms: float
    mean_square_n2: float

    def record(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def relative_rms(traces: Sequence[Trace]) -> tuple[FrequencyError, ...]:
    """The relative error over the frequency of the excitation, by rising frequency; from the whole judged cycles."""
    parts: dict[int, list[tuple[float, float, float, int]]] = {}
    grouped = group_cycles([t.measurement for t in traces])
    for trace, cycles in zip(traces, grouped.cycles, strict=True):
        forces = trace.residual, trace.measured
        for cycle in cycles:
            inside = slice(cycle.first, cycle.last)
            if trace.judged[inside].all():
                error, force = (float(np.sum(values[inside] ** 2)) for values in forces)
                place = round(_OCTAVE_SHARE * np.log2(cycle.frequency))
                parts.setdefault(place, []).append((cycle.frequency, error, force, cycle.last - cycle.first))
    rows = []
    for _, cycles in sorted(parts.items()):
        frequency, error, force, samples = np.array(cycles).T
        relative = float(np.sqrt(error.sum() / force.sum())) if force.sum() > 0.0 else float("nan")
        rmse = float(np.sqrt(error.sum() / samples.sum()))
        rows.append(FrequencyError(float(frequency.mean()), relative, rmse, len(cycles)))
    return tuple(rows)


def group_errors(traces: Sequence[Trace], limits: GroupLimits | None = None) -> tuple[GroupError, ...]:
    """Errors by groups of velocity and frequency, formed from the recordings' ranges where ``limits`` is None."""
    grouped = group_cycles([t.measurement for t in traces], limits)
    errors = []
    for index, name in enumerate(grouped.names):
        inside = [t.judged & (label == index) for t, label in zip(traces, grouped.labels, strict=True)]
        cycles = [c for part in grouped.cycles for c in part if grouped.limits.group(c) == name]
        if any(mask.any() for mask in inside):
            errors.append(_error(name, traces, inside, cycles))
    return tuple(errors)


def given_group_errors(traces: Sequence[Trace], groups: Mapping[str, Sequence[int]]) -> tuple[GroupError, ...]:
    """Errors of groups of whole recordings, by the user's name.

    Args:
        traces: all recordings.
        groups: indices of the recordings of each group.
    """
    cycles = group_cycles([t.measurement for t in traces]).cycles
    errors = []
    for name, members in groups.items():
        inside = [t.judged & (i in members) for i, t in enumerate(traces)]
        errors.append(_error(name, traces, inside, [c for i in members for c in cycles[i]]))
    return tuple(errors)


def _error(name: str, traces: Sequence[Trace], inside: Sequence[np.ndarray], cycles: Sequence) -> GroupError:
    squares = [t.residual[mask] ** 2 for t, mask in zip(traces, inside, strict=True) if mask.any()]
    forces = [t.measured[mask] ** 2 for t, mask in zip(traces, inside, strict=True) if mask.any()]
    error, force = (float(np.concatenate(part).mean()) for part in (squares, forces))
    velocities = [c.peak_velocity for c in cycles] or [np.nan]
    frequencies = [c.frequency for c in cycles] or [np.nan]
    return GroupError(
        name=name,
        recordings=len(squares),
        cycles=len(cycles),
        samples=sum(part.size for part in squares),
        peak_velocity_m_s=(min(velocities), max(velocities)),
        frequency_hz=(min(frequencies), max(frequencies)),
        rmse_n=float(np.sqrt(error)),
        relative_rms=float(np.sqrt(error / force)) if force > 0.0 else float("nan"),
        mean_square_n2=float(np.mean([part.mean() for part in squares])),
    )
