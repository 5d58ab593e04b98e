"""Over which travel a yield under current is tried to build up."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges

SHORT, LONG = 0.01, 0.05  # m: strokes up to which a quarter, and from which a twentieth counts


@pytest.mark.parametrize("name", ["command_slip", "command_yield"])
@given(stroke=st.floats(0.002, 0.3))
def test_the_travel_is_a_share_of_the_stroke_and_in_short_ones_up_to_millimetres(name, stroke):
    effect = find_effect(name)
    tried = effect.trial(
        Ranges(0.0, stroke, speed=0.3, acceleration=20.0, force=400.0, seconds=20.0, command=(0.0, 2.0))
    )
    low, high = tried.limits["way"]
    expected = 0.25 * stroke if stroke < SHORT else 2.5e-3 if stroke < LONG else 0.05 * stroke
    assert high == pytest.approx(expected)
    assert all(low <= way <= high for way in (tried.values["way"], *(start["way"] for start in tried.starts)))
