"""Vehicles with dampers: a quarter car on roads with a simulated damper and a controller in the loop; a whole car.

record = drive("road", DAMPERS["passenger_front"], seconds=60.0, seed=1)     # class C at 20 m/s
run = on_posts(load_car("compact_car"), {"front": model, "rear": model}, four_posts(sweep(0.003)))
"""

from damper_estimator.vehicle.closed_loop import (
    CornerSensors,
    Ride,
    RunningRide,
    Sensed,
    attainable,
    desired_force,
    ride,
)
from damper_estimator.vehicle.command_comparison import Trial, compare_commands, tracking_ratio
from damper_estimator.vehicle.damper_drives import EXCITATIONS, ROADS, drive
from damper_estimator.vehicle.four_posts import PostRun, Transfer, four_posts, on_posts, sweep, transfer
from damper_estimator.vehicle.full_car import WHEELS, Axle, Body, FullCar, library_vehicles, load_car
from damper_estimator.vehicle.quarter_car import CORNERS, QuarterCar, RunningCar, suspension_travel
from damper_estimator.vehicle.ride_measures import RideMeasures, ride_measures
from damper_estimator.vehicle.road import CLASSES, bump_height, pothole_height, profile_spectrum, road_height
from damper_estimator.vehicle.scenarios import CORNER_CASES, LIMITS, REST, SURFACES, Corner, Surface, surface_height
from damper_estimator.vehicle.single_curve import single_curve
from damper_estimator.vehicle.weighting import wk_gain, wk_weighted

__all__ = [
    "CLASSES",
    "CORNERS",
    "CORNER_CASES",
    "EXCITATIONS",
    "LIMITS",
    "REST",
    "ROADS",
    "SURFACES",
    "WHEELS",
    "Axle",
    "Body",
    "Corner",
    "CornerSensors",
    "FullCar",
    "PostRun",
    "QuarterCar",
    "Ride",
    "RideMeasures",
    "RunningCar",
    "RunningRide",
    "Sensed",
    "Surface",
    "Transfer",
    "Trial",
    "attainable",
    "bump_height",
    "compare_commands",
    "desired_force",
    "drive",
    "four_posts",
    "library_vehicles",
    "load_car",
    "on_posts",
    "pothole_height",
    "profile_spectrum",
    "ride",
    "ride_measures",
    "road_height",
    "single_curve",
    "surface_height",
    "suspension_travel",
    "sweep",
    "tracking_ratio",
    "transfer",
    "wk_gain",
    "wk_weighted",
]
