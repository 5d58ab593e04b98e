"""An error that stays as large in newtons is a larger share of the force on a smaller motion, and nothing new."""

from dataclasses import replace

import numpy as np
import pytest

import damper_estimator as de
from damper_estimator.diagnosis.misfit import KEY


def driven(size: float, name: str, stiffness: float = 0.0) -> de.Recording:
    """A damper with a line over velocity and dry friction, under a sum of sines of the given size."""
    time = np.arange(0.0, 40.0, 1.0 / 500.0)
    waves = [(0.7, 12.0, 0.3), (1.9, 6.0, 1.1), (4.3, 2.5, 2.0), (9.1, 0.9, 0.0)]
    x = sum(1e-3 * size * a * np.sin(2.0 * np.pi * f * time + p) for f, a, p in waves)
    v = sum(1e-3 * size * a * 2.0 * np.pi * f * np.cos(2.0 * np.pi * f * time + p) for f, a, p in waves)
    noise = np.random.default_rng(7).standard_normal(time.size)
    force = 2000.0 * v + 25.0 * np.tanh(v / 0.004) + stiffness * x + 2.0 * noise
    return de.Recording.from_arrays(time, x, force=force, name=name)


@pytest.fixture(scope="module")
def line():
    """The damper without its friction, and without the prediction of what it gets wrong."""
    model = de.fit(driven(1.0, "large"), "linear_viscous").model
    return replace(model, fit={key: value for key, value in model.fit.items() if key != KEY})


@pytest.mark.parametrize("size", [1.0, 0.65])
def test_the_same_error_in_newtons_is_nothing_new(line, size):
    found = de.diagnose(driven(size, "fit"), line, validate=driven(size, "unseen")).only
    assert found.verdict == "nothing_missing" and not found.findings
    assert found.rmse_n == pytest.approx(line.fit["residual_stddev"], rel=0.2)


def test_a_change_is_found_on_a_smaller_motion(line):
    found = de.diagnose(driven(0.65, "fit", 8000.0), line, validate=driven(0.65, "unseen", 8000.0)).only
    assert found.verdict == "missing" and found.findings[0].phenomenon in ("gas_spring", "spring_rate_error")
