"""A current that is not the command: the model's force is that of the current."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from motions import entry, force, sweep

from damper_estimator.signals.layout import COMMAND

FOLLOWS = (entry("command_yield"), entry("linear_viscous"))


@given(gain=st.floats(-0.9, 2.0), offset=st.floats(-1.0, 1.0), command=st.floats(-2.0, 2.0))
def test_the_force_is_that_of_the_current_in_the_coil(gain, offset, command):
    coil = np.copysign(max((1.0 + gain) * abs(command) - offset, 0.0), command if command else 1.0)
    found = force(sweep(command=command), entry("command_scale", gain=gain, offset=offset), *FOLLOWS)
    np.testing.assert_allclose(found, force(sweep(command=coil), *FOLLOWS), atol=1e-9)


def test_a_damper_without_a_command_is_left_alone():
    block = sweep()
    assert np.isnan(block[COMMAND]).all()
    scaled = force(block, entry("command_scale", gain=0.5, offset=0.1), entry("linear_viscous"))
    np.testing.assert_array_equal(scaled, force(block, entry("linear_viscous")))
