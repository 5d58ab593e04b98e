"""One cluster for all tests of the fleet: two workers, processes of their own."""

import pytest
from fleet_bags import quick, write_drive

from damper_estimator.fleet.cluster import connected
from damper_estimator.fleet.manifest import find_recordings
from damper_estimator.fleet.run import Asked, Fleet
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
    """Of a scheduler with two workers."""
    with connected(None, 2, "auto") as client:
        yield client


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL)
    return path


@pytest.fixture
def drives(tmp_path):
    """A folder of two vehicles with three recordings, one of them of two dampers."""
    folder = tmp_path / "cars"
    write_drive(folder / "car_a" / "monday.mcap", 1)
    write_drive(folder / "car_a" / "tuesday.mcap", 2, ("front_left", "front_right"), warm=40.0)
    write_drive(folder / "car_b" / "monday.mcap", 3)
    return folder


@pytest.fixture
def run(client, model, tmp_path):
    """Runs a fleet over patterns and returns it; by default of a work that does next to nothing."""

    def go(*patterns, work=quick, tell=lambda tally: None, options=COMPARE, output="out", **more):
        asked = Asked(options, str(model), tmp_path / output, **more)
        fleet = Fleet(asked, find_recordings([str(own) for own in patterns]), work, tell)
        fleet.run(client)
        return fleet

    return go
