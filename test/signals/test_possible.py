"""Displacements that no suspension can reach stay out of filter and model, and nothing is locked out."""

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, make_element
from damper_estimator.runtime import GOOD, DamperEstimator, deployed

MS = 1_000_000
STAMP = np.arange(4000) * MS
SECONDS = STAMP * 1e-9
MOTION = 0.03 * np.sin(2.0 * np.pi * 1.5 * SECONDS) + 0.002 * np.sin(2.0 * np.pi * 15.0 * SECONDS)
FIT = {"residual_stddev": 10.0, "region": {"velocity": [-9.0, 9.0]}}
HEATED = DamperModel(
    "m", "", tuple(make_element(find_effect(name)) for name in ("linear_viscous", "dissipation_fade")), fit=FIT
)


def run(displacement, cutoff=60.0):
    return DamperEstimator(deployed(HEATED, cutoff, 0.1)).block(STAMP, displacement)


WILD = {
    "one": ([1000], [1e5]),
    "metres": ([1000], [40.0]),
    "first": ([0], [-3e5]),
    "stuck for a while": (range(1000, 1050), 1e5),
    "stuck for long": (range(1000, 1300), 1e5),
    "at random": (range(1000, 1080), np.random.default_rng(0).uniform(-1.0, 1.0, 80)),
    "at random within the stroke": (range(1000, 2000), np.random.default_rng(1).uniform(-0.05, 0.05, 1000)),
    "alternating": (range(1000, 2000), 0.05 * (-1.0) ** np.arange(1000)),
    "another zero": (range(1000, 4000), MOTION[1000:] + 0.3),
}


@pytest.mark.parametrize("case", WILD)
def test_a_model_that_remembers_heat_is_right_wherever_it_is_good_after_wild_samples(case):
    places, values = WILD[case]
    displacement = MOTION.copy()
    displacement[list(places)] = values
    clean, hit = run(MOTION), run(displacement)
    good = (hit.status == GOOD) & ((STAMP < 1000 * MS) | (STAMP > 2100 * MS))
    assert good[-1] and np.count_nonzero(good) > 1000  # not locked out
    assert np.abs(hit.force - clean.force)[good].max() < 0.01 * np.abs(clean.force).max()


def test_fast_real_motion_passes_unchanged():
    """A pothole of 60 g, and 8 m/s at the end of a fall."""
    bump = 0.03 * np.exp(-(((SECONDS - 1.5) / 0.01) ** 2))
    fall = np.where(SECONDS > 2.0, np.minimum(8.0 * (SECONDS - 2.0), 0.1), 0.0)
    for displacement in (MOTION + bump, MOTION + fall):
        assert np.array_equal(run(displacement, cutoff=0.0).kinematics.displacement, displacement)


def test_millimetres_taken_for_metres_stay_visible():
    """They are counted as jumps and never good while they move."""
    hit = run(1e3 * MOTION)
    assert not (hit.status == GOOD).any() and hit.kinematics.stamp.size == STAMP.size
    assert np.abs(hit.kinematics.displacement).max() > 1.0
