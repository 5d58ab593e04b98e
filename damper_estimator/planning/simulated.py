"""Simulation of all steps with every hypothesis: force and derivatives in the rows in which recordings are compared."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from damper_estimator.diagnosis import Explanations, sensitivities
from damper_estimator.identification import rows_of
from damper_estimator.identification.rows import Rows
from damper_estimator.planning.steps import Step
from damper_estimator.signals import Measurement
from damper_estimator.signals.admission import DEFAULT_MAX_GAP
from damper_estimator.signals.kinematics import Differentiator, Kinematics

_SAMPLES_PER_BAND = 10.0  # samples per second over the band: as recordings are thinned for a diagnosis
_UNFILTERED = 400.0  # Hz, where there is no band


@dataclass(frozen=True)
class Simulated:
    """All steps, one after the other, as a recording would be seen.

    Attributes:
        rows: their rows, without zero taken out.
        step: (r,) int, the step of each row.
        force: (h, r) N of each hypothesis in band.
        sensitivity: of each hypothesis (r, k + 1), derivatives by its parameters times their sizes; the last is the
            gauge's zero.
        largest: (steps,) N, the largest force of any hypothesis.
        base: (r,) N of the model without any of them.
        base_slots: number of its parameters.
    """

    rows: Rows
    step: np.ndarray
    force: np.ndarray
    sensitivity: tuple[np.ndarray, ...]
    largest: np.ndarray
    base: np.ndarray
    base_slots: int

    @property
    def slices(self) -> list[slice]:
        """The rows of each step."""
        edges = np.searchsorted(self.step, np.arange(self.largest.size + 1))
        return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def simulated(found: Explanations, steps: Sequence[Step], like: Measurement) -> Simulated:
    """The hypotheses on the steps; filter, band and slow channels are those of the recording ``like``."""
    rows, first = _rows(steps, like)
    number = np.searchsorted(first, rows.picks, side="right") - 1
    forces, columns, largest = [], [], np.zeros(len(steps))
    for hypothesis in found.fitted:
        force, sensitivity = sensitivities(hypothesis, [rows])
        forces.append(np.nan_to_num(force))
        columns.append(np.column_stack([sensitivity, np.ones(force.size)]))
        np.maximum.at(largest, number, np.abs(forces[-1]))
    base = rows.of(np.nan_to_num(found.model.force(rows.measurement.kinematics.block)))
    return Simulated(rows, number, np.array(forces), tuple(columns), largest, base, len(found.model.slots))


def kinematics_of(step: Step, like: Measurement) -> Kinematics:
    """A step as the model would see its recording, at the rate that the band asks for."""
    wanted = _SAMPLES_PER_BAND * like.band if like.band > 0.0 else _UNFILTERED
    stride = max(1, int(step.limits.rate / wanted))
    displacement = np.ascontiguousarray(step.displacement[::stride])
    stamp = np.round(np.arange(displacement.size) * (1e9 * stride / step.limits.rate)).astype(np.int64)
    block = like.kinematics.block
    command = _median(block[5]) if step.current is None else step.current
    temperature = _median(block[6]) if step.temperature is None else step.temperature
    found, _ = Differentiator(like.cutoff, DEFAULT_MAX_GAP).block(
        stamp, displacement, command, temperature, _median(block[7])
    )
    return found


def _rows(steps: Sequence[Step], like: Measurement) -> tuple[Rows, np.ndarray]:
    """Rows of all steps as the stretches of one measurement, and the first sample of each."""
    parts, first, offset = [], [], 0
    for step in steps:
        parts.append(kinematics_of(step, like))
        first.append(offset)
        offset += len(parts[-1])
    ends = np.cumsum([0, *(int(part.stamp[-1]) + 10**9 for part in parts)])
    stamp = np.concatenate([part.stamp + start for part, start in zip(parts, ends, strict=False)])
    block = np.ascontiguousarray(np.concatenate([part.block for part in parts], axis=1))
    block[0] = stamp / 1e9
    kinematics = Kinematics(stamp, block)
    nothing = np.zeros(stamp.size)
    measurement = Measurement(
        recording="plan", damper=like.damper, kinematics=kinematics, force=nothing, judged=kinematics.warm(),
        counts=like.counts, gauge=np.zeros(0), raw_displacement=block[2], cutoff=like.cutoff, band=like.band,
        signals=like.signals,
    )  # fmt: skip
    return rows_of(measurement), np.array(first)


def _median(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else float("nan")
