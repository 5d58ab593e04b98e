"""What changes in one direction of the flow leaves the other one alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import entry, force, sweep

from damper_estimator.signals.layout import V

PLAIN = entry("linear_viscous", rebound=3000.0, compression=2000.0)
SIDES = pytest.mark.parametrize("side", [1.0, -1.0])


@SIDES
@given(gain=st.floats(-0.8, 2.0), at_rest=st.floats(-500.0, 500.0))
def test_the_force_of_one_direction_is_scaled_about_the_force_at_rest(side, gain, at_rest):
    block = sweep()
    rest = entry("static_force", force=at_rest)
    before = force(block, rest, PLAIN) - at_rest
    after = force(block, rest, PLAIN, entry("direction_gain", gain=gain, side=side, at_rest=at_rest)) - at_rest
    there = side * before > 0.0
    np.testing.assert_allclose(after, np.where(there, (1.0 + gain) * before, before), atol=1e-9)


@SIDES
def test_a_lagging_force_is_scaled_where_the_force_has_that_direction(side):
    """The valves of a direction see its pressure, which lags behind the velocity where the oil yields."""
    block, spring = sweep(), entry("oil_spring", (PLAIN,), stiffness_rebound=2e5, stiffness_compression=2e5)
    before, after = (force(block, spring, *more) for more in ((), (entry("direction_gain", gain=0.5, side=side),)))
    assert (side * before[block[V] * side < 0.0] > 1.0).any(), "the spring makes no lag that matters"
    np.testing.assert_allclose(after, np.where(side * before > 0.0, 1.5 * before, before))


@SIDES
@given(share=st.floats(-0.9, 0.9), opening=st.floats(0.01, 1.0))
def test_a_leak_of_one_direction_takes_its_share_at_low_speed_and_less_beyond(side, share, opening):
    block = sweep()
    leak = entry("one_way_leak", share=share, opening=opening, side=side)
    before, after = (force(block, *more, PLAIN) for more in ((), (leak,)))
    speed = side * block[V]
    np.testing.assert_array_equal(after[speed <= 0.0], before[speed <= 0.0])
    taken = 1.0 - after[speed > 0.0] / before[speed > 0.0]
    np.testing.assert_allclose(taken, share / np.sqrt(1.0 + speed[speed > 0.0] / opening), atol=1e-9)
