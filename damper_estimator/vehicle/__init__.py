"""A quarter car on an ISO 8608 road, with a simulated damper in the loop.

record = drive("road", DAMPERS["passenger_front"], seconds=60.0, seed=1)     # class C at 20 m/s
"""

from damper_estimator.vehicle.excitation import EXCITATIONS, ROADS, drive
from damper_estimator.vehicle.quarter_car import CORNERS, QuarterCar, suspension_travel
from damper_estimator.vehicle.road import CLASSES, bump_height, profile_spectrum, road_height

__all__ = [
    "CLASSES",
    "CORNERS",
    "EXCITATIONS",
    "ROADS",
    "QuarterCar",
    "bump_height",
    "drive",
    "profile_spectrum",
    "road_height",
    "suspension_travel",
]
