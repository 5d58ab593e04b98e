"""Numerical measures of a ride."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.vehicle.closed_loop import Ride
from damper_estimator.vehicle.weighting import wk_weighted


@dataclass(frozen=True)
class RideMeasures:
    """Over the measured part of a ride.

    Attributes:
        tracking_n: rms difference of the damper's force and the desired force limited to the attainable range, N.
        tracking_raw_n: the same with the unlimited desired force.
        wanted_n: rms of the limited desired force about its mean, N.
        weighted_acceleration: of the body, Wk, m/s^2 rms.
        acceleration: m/s^2 rms, unweighted.
        tyre_load: rms change of the tyre's load over the static load, 1.
        lowest_tyre_load: over the static load, 1; 0 is lifted off.
        stroke, peak_stroke: rms about the mean and largest, m.
    """

    tracking_n: float
    tracking_raw_n: float
    wanted_n: float
    weighted_acceleration: float
    acceleration: float
    tyre_load: float
    lowest_tyre_load: float
    stroke: float
    peak_stroke: float


def ride_measures(ride: Ride, desired: np.ndarray, attainable: np.ndarray, start: float) -> RideMeasures:
    """Measures from ``start`` s on.

    Args:
        desired: (n,) N, the force that the damper should have at this moment.
        attainable: (2, n) N, lowest and highest force on this motion.
    """
    part = slice(round(start / ride.step), None)
    raw = desired[part]
    wanted = np.clip(raw, attainable[0, part], attainable[1, part])
    force, travel = ride.force[part], ride.travel[part]
    tyre = ride.tyre_force[part] / ride.static_load

    def rms(values: np.ndarray) -> float:
        return float(np.sqrt(np.mean(values**2)))

    return RideMeasures(
        tracking_n=rms(force - wanted),
        tracking_raw_n=rms(force - raw),
        wanted_n=float(np.std(wanted)),
        weighted_acceleration=rms(wk_weighted(ride.body_acceleration, ride.step)[part]),
        acceleration=rms(ride.body_acceleration[part]),
        tyre_load=rms(tyre),
        lowest_tyre_load=float(1.0 + tyre.min()),
        stroke=float(np.std(travel)),
        peak_stroke=float(np.abs(travel).max()),
    )
