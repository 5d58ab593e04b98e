"""The step test: the damper is moved by some 50 mm at once and held; force over displacement, measured and modelled.

A step passes every speed from rest to its peak and back within one stroke, so it shows effects that sines hide: the gas
force left at both ends, the opening of the valves on the way up and their closing on the way down. Source: Carrera
Akutain et al., section 5 and figure 14 (two-post rig, 50 mm; the force-displacement plot states the
correlation coefficient).
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.validation.measures import Measures, measures
from damper_estimator.validation.trace import trace

LEAST_HEIGHT = 0.010  # m, of a motion that counts as a step
_MOVING = 0.05  # of the largest speed
_SETTLING = 0.10  # s after a step that count as part of it
_LONGEST = 1.0  # s, duration of a step
_REST = 0.2  # s of standstill before and after it


@dataclass(frozen=True)
class JudgedStep:
    """One step of the test.

    Attributes:
        time: s since the recording's first sample, at which it begins.
        seconds: duration of the motion.
        height: m, positive in extension.
        peak_velocity: m/s, signed like the height.
        displacement, measured, modelled: (n,) m and N in band, for the F-x figure.
        measures: agreement over the step, settling included.
    """

    time: float
    seconds: float
    height: float
    peak_velocity: float
    displacement: np.ndarray
    measured: np.ndarray
    modelled: np.ndarray
    measures: Measures


def step_check(
    model: DamperModel, measurement: Measurement, least_height: float = LEAST_HEIGHT
) -> tuple[JudgedStep, ...]:
    """Judges a model on every step of a step test.

    Args:
        model: of the damper.
        measurement: of a motion that rests, moves once in one direction, and rests again.
        least_height: m; smaller moves are ignored.

    Raises:
        InputError: where the recording has no step, or nothing to judge.
    """
    forces = trace(model, measurement)
    kinematics = measurement.kinematics
    steps = []
    for inside in _moves(measurement, least_height):
        until = int(np.searchsorted(kinematics.time, kinematics.time[inside.stop - 1] + _SETTLING))
        window = np.arange(inside.start, until)[forces.judged[inside.start : until]]
        if window.size < 4:
            continue
        velocity = kinematics.velocity[inside]
        steps.append(
            JudgedStep(
                time=float(kinematics.time[inside.start]),
                seconds=float(kinematics.time[inside.stop - 1] - kinematics.time[inside.start]),
                height=_height(measurement, inside),
                peak_velocity=float(velocity[np.argmax(np.abs(velocity))]),
                displacement=kinematics.displacement[window],
                measured=forces.measured[window],
                modelled=forces.modelled[window],
                measures=measures(
                    forces.measured[window], forces.modelled[window], kinematics.velocity[window], kinematics.dt[window]
                ),
            )
        )
    if not steps:
        raise InputError(
            f"{measurement.recording}: damper {measurement.damper} makes no step of {1e3 * least_height:g} mm "
            "or more between two rests; a step "
            "test moves some 50 mm within a tenth of a second and holds"
        )
    return tuple(steps)


def _height(measurement: Measurement, inside: slice) -> float:
    x = measurement.kinematics.displacement
    return float(x[inside.stop - 1] - x[inside.start])


def _moves(measurement: Measurement, least_height: float) -> list[slice]:
    """Runs of motion in one direction, between rests, of enough height and not too slow."""
    kinematics = measurement.kinematics
    velocity = kinematics.velocity
    direction = np.where(np.abs(velocity) > _MOVING * float(np.abs(velocity).max(initial=0.0)), np.sign(velocity), 0.0)
    direction[kinematics.dt <= 0.0] = 0.0
    edges = [0, *(np.flatnonzero(np.diff(direction)) + 1).tolist(), velocity.size]
    runs = [slice(first, last) for first, last in zip(edges, edges[1:], strict=False) if last > first]

    def rests(index: int) -> bool:
        """Whether run ``index`` is a rest of some length; the ends of the recording count as rest."""
        if not 0 <= index < len(runs):
            return True
        return direction[runs[index].start] == 0.0 and (
            index in (0, len(runs) - 1) or _seconds(measurement, runs[index]) >= _REST
        )

    return [
        inside
        for index, inside in enumerate(runs)
        if direction[inside.start] != 0.0
        and rests(index - 1)
        and rests(index + 1)
        and _seconds(measurement, inside) <= _LONGEST
        and abs(_height(measurement, inside)) >= least_height
    ]


def _seconds(measurement: Measurement, inside: slice) -> float:
    time = measurement.kinematics.time
    return float(time[inside.stop - 1] - time[inside.start])
