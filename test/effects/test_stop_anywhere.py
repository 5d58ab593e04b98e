"""A stop is tried at the ends of the recorded stroke, wherever the zero of the displacement is; its spring."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import entry, force, standing

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges, Untestable
from damper_estimator.signals.layout import X


@pytest.mark.parametrize("name", ["end_stop", "hydraulic_stop"])
@given(zero=st.floats(-0.3, 0.3), stroke=st.floats(0.004, 0.15))
def test_stops_leave_a_third_of_the_stroke_free(name, zero, stroke):
    effect = find_effect(name)
    tried = effect.trial(Ranges(zero, zero + stroke, speed=1.0, acceleration=50.0, force=500.0, seconds=20.0))
    low, high = (name for name in tried.limits if name.endswith("position"))
    assert tried.limits[low] == pytest.approx((zero, zero + stroke * 2.0 / 3.0))
    assert tried.limits[high] == pytest.approx((zero + stroke / 3.0, zero + stroke))
    bounds = {parameter.name: (parameter.lower, parameter.upper) for parameter in effect.parameters}
    for position in (low, high):
        assert bounds[position][0] <= tried.limits[position][0] < tried.limits[position][1] <= bounds[position][1]


@pytest.mark.parametrize("name", ["end_stop", "hydraulic_stop"])
def test_a_stroke_of_almost_nothing_reaches_no_stop(name):
    with pytest.raises(Untestable, match="too short"):
        find_effect(name).trial(Ranges(0.08, 0.082, speed=1.0, acceleration=50.0, force=500.0, seconds=20.0))


def test_the_spring_of_a_hydraulic_stop_pushes_back_to_the_middle_at_rest():
    block = standing(np.linspace(-0.06, 0.05, 45))
    stops = {"bump_position": -0.05, "bump_stiffness": 2e4, "rebound_position": 0.04, "rebound_stiffness": 3e4}
    computed, x = force(block, entry("hydraulic_stop", **stops)), block[X]
    assert computed == pytest.approx(3e4 * np.maximum(x - 0.04, 0.0) - 2e4 * np.maximum(-0.05 - x, 0.0))
