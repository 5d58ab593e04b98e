"""A clock that drifts makes the force later and later, whatever the motion does."""

import numpy as np
import pytest

from damper_estimator.validation import data_findings

SECONDS = 60.0


@pytest.fixture
def late(motion, measured):
    """Kinds of the findings in a recording whose force gets later by 3 ms, on a motion whose size is times a function
    of time from 0 to 1."""

    def make(size):
        time, x = motion(SECONDS, seed=3)
        share = time / SECONDS

        def force(k):
            curve = 1500.0 * np.tanh(k.velocity / 0.3)
            return np.interp(k.time - 3e-3 * (k.time - k.time[0]) / SECONDS, k.time, curve)

        return {one.kind for one in data_findings(None, [measured(time, x * size(share), force)])}

    return make


@pytest.mark.parametrize("size", [lambda t: 1.0 + 0.0 * t, lambda t: 1.0 + 0.6 * np.sin(40.0 * t)])
def test_a_drifting_clock_is_found_on_motion_of_one_size_and_of_changing_size(size, late):
    assert "clock_drift" in late(size)


def test_lateness_that_grows_with_the_motion_may_be_the_dampers(late):
    """Steps of amplitude, as of a bench: a valve or a mount is as late as the clock would be."""
    assert "clock_drift" not in late(lambda t: 0.3 * 5.0 ** (np.floor(8.0 * np.minimum(t, 0.999)) / 7.0))
