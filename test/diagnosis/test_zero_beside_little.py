"""A gauge that was tared anew, and a model that errs a little: the zero is named, and nothing beside it."""

import numpy as np
import pytest
from roads import road

import damper_estimator as de

RATE, SECONDS = 400.0, 30.0


def recording(name: str, seed: int, size: float = 1.0, zero: float = 0.0, mass: float = 0.0) -> de.Recording:
    """A digressive damper on a road of this size, behind a mass that no model has."""
    random, time = np.random.default_rng(seed), np.arange(round(RATE * SECONDS)) / RATE
    x = road(random, time, 14.0, size=size * 3e-3, slope=1.5)
    v = np.gradient(x, time)
    force = 700.0 * np.arctan(6.0 * v) + 400.0 * v + mass * np.gradient(v, time) + zero
    return de.Recording.from_arrays(time, x, force=force + 1.0 * random.standard_normal(v.size), name=name)


@pytest.mark.parametrize("mass", [0.0, 1.8])
def test_beside_a_zero_nothing_is_named_that_would_be_too_small_without_it(mass):
    model = de.fit(recording("base", 1), "viscous_curve").model
    fit, unseen = (recording(n, seed, zero=z, mass=mass) for n, seed, z in (("fit", 2, 40.0), ("unseen", 3, 60.0)))
    found = de.diagnose(fit, model, validate=unseen).diagnosis.findings
    assert [one.phenomenon for one in found] == ["force_offset"]


def test_beside_a_zero_an_effect_that_counts_is_named():
    model = de.fit(recording("base", 1), "viscous_curve").model
    fit, unseen = (recording(n, seed, zero=z, mass=6.0) for n, seed, z in (("fit", 2, 40.0), ("unseen", 3, 60.0)))
    found = de.diagnose(fit, model, validate=unseen).diagnosis.findings
    assert {one.phenomenon for one in found} == {"force_offset", "inertia"}
