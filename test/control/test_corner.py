"""The controller of a corner passes the same desired force and kinematics to every kind of command."""

import numpy as np
import pytest
from commanded_models import HIGHEST, LOWEST, commanded_models, entry, model_of, smooth_motion
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.control import (
    Action,
    ConstantCommand,
    CornerController,
    CurrentTable,
    InverseCommand,
    InverseModel,
    TableCommand,
    groundhook,
    mixed,
    skyhook,
)
from damper_estimator.signals.layout import COMMAND, DT, A, V

TABLE = CurrentTable(np.array([-1.0, 1.0]), np.array([LOWEST, HIGHEST]), np.array([[-500.0, -1500.0], [500.0, 1500.0]]))


def commands() -> list:
    inverse = InverseModel(commanded_models()["without a lag"], (LOWEST, HIGHEST))
    return [InverseCommand(inverse), TableCommand(TABLE), ConstantCommand(0.7)]


def test_the_desired_force_is_that_of_the_law_plus_the_force_at_rest_for_every_command():
    block = smooth_motion(200, 1)
    desired = []
    for command in commands():
        controller, block[COMMAND] = CornerController(skyhook(2000.0), command, rest_force=-300.0), 0.0
        desired.append([controller.step(column, np.sin(0.1 * k)).wanted for k, column in enumerate(block.T)])
    assert desired[0] == desired[1] == desired[2]
    assert desired[0][0] == -300.0
    assert np.ptp(desired[0]) > 10.0


@given(
    velocity=st.floats(-1.0, 1.0),
    acceleration=st.floats(-50.0, 50.0),
    felt=st.floats(-5.0, 5.0),
    lead=st.sampled_from([0.0, 0.004, 0.02]),
)
def test_law_and_command_refer_to_the_same_moment(velocity, acceleration, felt, lead):
    """Ahead by ``lead`` s is the same as at a sample that is so much later, if accelerations are constant."""
    law = mixed(2000.0, 0.7)

    def answer(ahead: float, start: float) -> Action:
        controller = CornerController(law, TableCommand(TABLE, ahead), 450.0, lead=ahead)
        sample = np.zeros(8)
        for k in range(5):
            time = start + 0.1 * k
            sample[DT], sample[V], sample[A] = 0.1 * (k > 0), velocity + acceleration * time, acceleration
            action = controller.step(sample, felt)
        return action

    early, late = answer(lead, 0.0), answer(0.0, lead)
    # The body's velocity is integrated from rest on, so only it is not ``lead`` s further.
    assert early.wanted == pytest.approx(late.wanted + law.body * lead * felt - law.wheel * lead * felt, abs=1e-6)


def test_a_table_is_read_at_the_velocity_ahead():
    sample = np.zeros(8)
    sample[V], sample[A] = 0.4, -20.0
    assert TableCommand(TABLE, 0.01).current(sample, 350.0) == pytest.approx(TABLE.current_for(0.2, 350.0))
    assert TableCommand(TABLE).current(sample, 350.0) == pytest.approx(TABLE.current_for(0.4, 350.0))


def test_currents_are_those_of_the_command():
    sample = np.array([0.0, 0.0, 0.0, 0.4, 0.0, 0.2, np.nan, np.nan])
    law = skyhook(0.0)
    assert CornerController(law, ConstantCommand(0.7)).step(sample, 0.0).current == 0.7
    by_table = CornerController(law, TableCommand(TABLE), 450.0).step(sample, 0.0)
    assert by_table.current == pytest.approx(TABLE.current_for(0.4, 450.0))
    model = commanded_models()["without a lag"]
    by_model = CornerController(law, InverseCommand(InverseModel(model, (LOWEST, HIGHEST))), 450.0)
    assert by_model.step(sample, 0.0).current == InverseModel(model, (LOWEST, HIGHEST)).solve(sample, 450.0).current


def test_without_a_current_the_fallback_is_used():
    silent = model_of(entry("viscous"), entry("semi_active_squash"))
    controller = CornerController(skyhook(1.0), InverseCommand(InverseModel(silent, (LOWEST, HIGHEST))), 0.0, 0.3)
    sample = np.array([0.0, 0.0, 0.0, np.nan, 0.0, 0.2, np.nan, np.nan])
    assert controller.step(sample, 0.0).current == 0.3


def test_the_limit_bounds_the_desired_force_relative_to_the_force_at_rest():
    sample = np.zeros(8)
    for velocity, wanted in ((0.4, -50.0), (-0.4, -350.0), (0.05, -150.0)):
        sample[V] = velocity
        action = CornerController(groundhook(1000.0), ConstantCommand(0.0), -200.0).step(sample, 0.0, limit=150.0)
        assert action.wanted == pytest.approx(wanted)
    sample[V] = np.nan
    assert np.isnan(CornerController(groundhook(1000.0), TableCommand(TABLE)).step(sample, 0.0, limit=150.0).wanted)
