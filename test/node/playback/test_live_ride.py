"""The simulated quarter car in the loop of real processes over DDS rides as it does offline."""

import numpy as np
import pytest

from damper_estimator.model import load_model
from damper_estimator.model.force_table import force_table, write_tables
from damper_estimator.vehicle import CORNER_CASES, LIMITS, REST, SURFACES, surface_height

MODEL = "semi_active_on_mount"


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("by_table", [False, True])
def test_the_ride_over_dds_equals_the_ride_offline(by_table, identified, domain, tmp_path):
    from damper_estimator.node.playback.live_ride import Scenario, live, offline

    name, table = identified(MODEL, command=list(LIMITS)), None
    if by_table:
        model = load_model(name)
        forces = force_table(model, np.array([-1.0, -0.5, -0.2, -0.05, 0.05, 0.2, 0.5, 1.0]), commands=LIMITS)
        table = write_tables(model, forces, tmp_path)[0]
    (bump,) = [surface for surface in SURFACES if surface.kind == "bump"]
    scenario = Scenario(CORNER_CASES["semi_active"], surface_height(bump, 2.6, 1)[:20_000], name, table)
    there, here = live(scenario), offline(scenario)
    part = slice(round(REST / here.step), None)
    assert np.ptp(here.current[part]) > 0.5 and rms(here.travel[part]) > 1e-3  # it rides, and is controlled
    for name in ("travel", "force", "wanted", "body_acceleration", "tyre_force"):
        mine, theirs = getattr(here, name)[part], getattr(there, name)[part]
        assert rms(theirs - mine) < 1e-3 * np.std(mine), name
