"""Runs the node's line over the messages of a recording and counts the results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from damper_estimator.control import InverseModel, checked_limits, usable_limits
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.recordings import BagWriter, damper_forces, joint_states
from damper_estimator.runtime import (
    DamperEstimator,
    Deployed,
    Estimates,
    ForceMessages,
    ResidualLine,
    Residuals,
    VehicleLine,
    deployed,
    group_equal_keys,
)
from damper_estimator.signals import DUPLICATE, Counts, SignalMap
from damper_estimator.workflows.arrivals import Chunk

FORCE, FORCE_TYPE = "/damper_estimator/force", "damper_msgs/msg/DamperForces"
RESIDUAL, RESIDUAL_TYPE = "/damper_estimator/residual", "sensor_msgs/msg/JointState"
_NO_STAMPS = np.zeros(0, np.int64)


@dataclass
class ReplayCounts:
    """Counts of one damper's samples and estimates."""

    counts: Counts = field(default_factory=Counts)
    estimates: int = 0
    not_finite: int = 0
    residuals: int = 0
    squared_residual: float = 0.0

    @property
    def residual_rms_n(self) -> float | None:
        """rms of the residual, N; None without one."""
        return float(np.sqrt(self.squared_residual / self.residuals)) if self.residuals else None

    def record(self) -> dict[str, object]:
        """For JSON."""
        names = ("samples", "gaps", "steps_back", "inversions", "duplicates", "non_finite")
        return {name: getattr(self.counts, name) for name in names} | {
            "estimates": self.estimates,
            "force_not_finite": self.not_finite,
            "residuals": self.residuals,
            "residual_rms_n": self.residual_rms_n,
        }


@dataclass(frozen=True)
class LineOutput:
    """The output for a chunk of messages: messages to send, estimates and residuals by damper."""

    messages: list[ForceMessages]
    estimates: Mapping[str, Estimates]
    residuals: Mapping[str, Residuals]


class ReplayLine:
    """All dampers of a vehicle, as the node runs them; memory does not grow with the recording; final.

    Attributes:
        tallies: counts by damper so far.
    """

    def __init__(
        self, models: Mapping[str, DamperModel], chosen: SignalMap, max_gap: float, measured: set[str]
    ) -> None:
        """``measured``: names of dampers with a force channel."""
        dampers = {
            name: deployed(model, chosen.cutoff, max_gap, fusion=chosen.fusion, signals=chosen.dampers[name])
            for name, model in models.items()
        }
        self._line = VehicleLine({name: DamperEstimator(damper) for name, damper in dampers.items()}, _reaches(dampers))
        self._residuals = {
            name: ResidualLine(chosen.dampers[name], chosen.gauge_cutoff, max_gap)
            for name in models
            if name in measured
        }
        self.tallies = {name: ReplayCounts() for name in models}

    def take(self, chunk: Chunk) -> LineOutput:
        """Runs the next messages."""
        messages, estimates = self._line.block(chunk.displacement, chunk.slow)
        for name, found in estimates.items():
            tally = self.tallies[name]
            tally.counts += Counts.of(found.verdict)
            tally.estimates += found.force.size
            tally.not_finite += int(np.count_nonzero(np.isnan(found.force)))
        residuals = {name: self._residual(name, chunk, estimates.get(name)) for name in self._residuals}
        return LineOutput(messages, estimates, residuals)

    def _residual(self, name: str, chunk: Chunk, estimates: Estimates | None) -> Residuals:
        measured = chunk.gauge.get(name)
        found = self._residuals[name].block(
            estimates,
            chunk.log[name][estimates.verdict < DUPLICATE] if estimates is not None else _NO_STAMPS,
            measured.stamp if measured is not None else _NO_STAMPS,
            measured.value if measured is not None else np.zeros(0),
        )
        finite = found.value[np.isfinite(found.value)]
        self.tallies[name].residuals += finite.size
        self.tallies[name].squared_residual += float(np.sum(finite**2))
        return found


def write_output(writer: BagWriter, chunk: Chunk, output: LineOutput) -> None:
    """Writes estimates at the log times of their displacements, and residuals."""
    ranks, logs = _sorted_logs(chunk)
    for m in output.messages:
        at = logs[np.searchsorted(ranks, m.rank)]
        writer.write_messages(FORCE, FORCE_TYPE, at, damper_forces(m.names, m.stamp, m.fields))
    residuals = output.residuals
    for stamp, rows in group_equal_keys({name: residual.stamp for name, residual in residuals.items()}):
        first = next(iter(rows))
        effort = np.stack([residuals[name].value[chosen] for name, chosen in rows.items()], axis=1)
        at = residuals[first].log[rows[first]]
        writer.write_messages(RESIDUAL, RESIDUAL_TYPE, at, joint_states(list(rows), stamp, effort=effort))


def _sorted_logs(chunk: Chunk) -> tuple[np.ndarray, np.ndarray]:
    """Log times of all displacement messages by rank."""
    rank = np.concatenate([_NO_STAMPS, *(arrivals.rank for arrivals in chunk.displacement.values())])
    logs = np.concatenate([_NO_STAMPS, *chunk.log.values()])
    ranks, first = np.unique(rank, return_index=True)
    return ranks, logs[first]


def _reaches(dampers: Mapping[str, Deployed]) -> dict[str, Callable[[np.ndarray], np.ndarray]]:
    """Functions for the reachable forces of dampers whose model has an inverse; as the node does by default."""
    found: dict[str, Callable[[np.ndarray], np.ndarray]] = {}
    for name, damper in dampers.items():
        with suppress(InputError):
            checked_limits(damper.model, damper.signals.command.value_limits)
            found[name] = InverseModel(damper.model, usable_limits(name, damper)[0]).reach
    return found
