"""One cluster for all tests of the fleet: two workers, each a process."""

import pytest
from fleet_bags import quick, write_drive

from damper_estimator.fleet.cluster import connected
from damper_estimator.fleet.manifest import find_recordings
from damper_estimator.fleet.scheduling import Fleet, FleetRequest
from damper_estimator.fleet.verbs import Compare

COMPARE = Compare()
MODEL = """\
name: viscous_and_friction
source: made for a test
effects:
  - linear_viscous: {rebound: 1400.0, compression: 1400.0}
  - tanh_hysteresis: {}
"""


@pytest.fixture(scope="session")
def client():
    """A client of a scheduler with two workers."""
    with connected(None, 2, "auto") as client:
        yield client


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL)
    return path


@pytest.fixture
def drives(tmp_path):
    """A folder with two vehicles and three recordings, one of them with two dampers."""
    folder = tmp_path / "cars"
    write_drive(folder / "car_a" / "monday.mcap", 1)
    write_drive(folder / "car_a" / "tuesday.mcap", 2, ("front_left", "front_right"), warm=40.0)
    write_drive(folder / "car_b" / "monday.mcap", 3)
    return folder


@pytest.fixture
def run(client, model, tmp_path):
    """Runs a fleet over patterns and returns it; by default with trivial work."""

    def go(*patterns, work=quick, progress=lambda counts: None, options=COMPARE, output="out", **more):
        request = FleetRequest(options, str(model), tmp_path / output, **more)
        fleet = Fleet(request, find_recordings([str(pattern) for pattern in patterns]), work, progress)
        fleet.run(client)
        return fleet

    return go
