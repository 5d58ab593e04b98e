"""Comparison of several ways to set the current, with the same road, desired force and sensors."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from damper_estimator.control import LEAD, Command, CornerController, Law
from damper_estimator.model import load_model
from damper_estimator.plant import STEP
from damper_estimator.runtime import DamperEstimator, deployed
from damper_estimator.vehicle.closed_loop import Ride, RunningRide, attainable, desired_force, ride
from damper_estimator.vehicle.ride_measures import RideMeasures, ride_measures
from damper_estimator.vehicle.scenarios import LIMITS, REST, Corner, Surface, surface_height

CUTOFF, MAX_GAP = 60.0, 0.1
"""Hz and s, of the filter before every controller."""


@dataclass(frozen=True)
class Trial:
    """A ride, the law's force at its true velocities ((n,) N), the attainable forces on its motion ((2, n) N), and its
    measures."""

    ride: Ride
    desired: np.ndarray
    attainable: np.ndarray
    measures: RideMeasures


def compare_commands(
    corner: Corner,
    surface: Surface,
    commands: Mapping[str, Command],
    seconds: float,
    seed: int,
    law: Law | None = None,
    lead: float = LEAD,
    step: float = STEP,
) -> dict[str, Trial]:
    """Drives the corner over the surface once with each command, by name; all from the same seed.

    Args:
        commands: new ones; they have memory.
        seconds: of the drive; its first second is at rest and not measured.
        law: replaces the corner's law.
        lead: s, of all commands.
    """
    law = law or corner.law
    road = surface_height(surface, seconds, seed, step)
    found = {}
    for name, command in commands.items():
        rest_force = RunningRide(corner.car, corner.damper, road, step=step).rest_force
        controller = CornerController(law, command, rest_force, lead=lead)
        # Only its filter is used: all controllers receive the same kinematics.
        estimator = DamperEstimator(deployed(load_model("linear_viscous"), CUTOFF, MAX_GAP))
        run = ride(corner.car, corner.damper, road, controller, estimator, seed=seed, step=step)
        limits = attainable(corner.damper, run.travel, LIMITS, step)
        desired = desired_force(run, law, rest_force)
        found[name] = Trial(run, desired, limits, ride_measures(run, desired, limits, REST))
    return found


def tracking_ratio(trials: Mapping[str, Trial], one: str = "model", other: str = "table") -> float:
    """Ratio of the tracking errors of two commands."""
    return trials[one].measures.tracking_n / trials[other].measures.tracking_n
