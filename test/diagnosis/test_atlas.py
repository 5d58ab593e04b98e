"""The form-free tests: which variable an error depends on, whatever its form."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis.atlas_terms import TESTS, hats, play
from damper_estimator.diagnosis.baseline import baseline_of
from damper_estimator.diagnosis.diagnosis_data import data_of, force_rows, targets
from damper_estimator.diagnosis.evaluation import evaluated_tests
from damper_estimator.effects.discovery import all_effects
from damper_estimator.signals.layout import COMMAND, TEMPERATURE


@pytest.fixture(scope="module")
def perfect(user_model, base):
    """The base recording as the model itself would have made it, with two slow channels that vary."""
    block = base.kinematics.block.copy()
    time = base.kinematics.time - base.kinematics.time[0]
    block[TEMPERATURE] = 20.0 + 25.0 * (1.0 - np.exp(-time / 10.0))
    block[COMMAND] = 0.7 + 0.5 * np.sin(1.3 * time)
    kinematics = replace(base.kinematics, block=block)
    return replace(base, kinematics=kinematics, force=user_model.force(block))


HIDDEN = {
    "temperature": lambda k, force: -0.004 * (k.temperature - 20.0) * force,
    "current": lambda k, force: 60.0 * np.sqrt(k.command) * np.tanh(k.velocity / 0.03),
    "mass": lambda k, force: 2.0 * k.acceleration,
    "shift": lambda k, force: 0.001 * np.gradient(force, k.time),
    "blow-off": lambda k, force: -0.4 * force * np.maximum(np.abs(k.velocity) - 0.15, 0.0),
    "even": lambda k, force: 70.0 * np.abs(k.velocity) ** 0.7,
    "rebound": lambda k, force: 70.0 * np.maximum(k.velocity, 0.0) ** 0.5,
    "compression": lambda k, force: -70.0 * np.maximum(-k.velocity, 0.0) ** 0.5,
    "stops": lambda k, force: 4e6 * np.maximum(np.abs(k.displacement - np.median(k.displacement)) - 0.022, 0.0) ** 2,
    "friction step": lambda k, force: play(k.displacement, k.dt, 7e-4) * 80.0,
}


@pytest.mark.parametrize("name", HIDDEN)
def test_what_was_hidden_shows_in_its_test_and_not_in_a_wrong_one(name, user_model, perfect):
    change = HIDDEN[name](perfect.kinematics, perfect.force)
    middle = len(change) // 2
    measured = replace(perfect, force=perfect.force + change)
    baseline = baseline_of(
        user_model, data_of(user_model, [measured.part(0, middle)], [measured.part(middle, len(change))])
    )
    rows = {test.test.name: test for test in evaluated_tests(baseline, "kept")}
    assert rows[name].error < 0.25
    simpler = [other for other in rows if other != name and name not in rows[other].test.contains]
    assert rows[name].error <= min(rows[other].error for other in simpler) + 0.05


def test_the_tests_that_effects_name_exist():
    known = {test.name for test in TESTS}
    for effect in all_effects().values():
        assert set(effect.tests) <= known, effect.name
        assert not effect.tests or effect.phenomenon
    assert all(set(test.contains) <= known for test in TESTS)


def test_hat_functions_add_up_to_one_and_reproduce_straight_lines():
    values, knots = np.linspace(-2.0, 2.0, 41), np.array([-1.0, -0.2, 0.0, 0.5, 1.0])
    columns = np.array(hats(values, knots))
    np.testing.assert_allclose(columns.sum(axis=0), 1.0)
    inside = np.abs(values) <= 1.0
    np.testing.assert_allclose((knots @ columns)[inside], values[inside], atol=1e-12)


def test_a_play_element_is_elastic_then_slips_and_forgets_at_a_reset():
    x = np.concatenate([np.linspace(0.0, 3e-3, 31), np.linspace(3e-3, 0.0, 31)])
    dt = np.full(x.size, 1e-3)
    dt[0] = 0.0
    share = play(x, dt, 1e-3)
    assert share[5] == pytest.approx(0.5) and share[30] == 1.0 and share[-1] == -1.0
    dt[40] = 0.0
    assert play(x, dt, 1e-3)[40] == 0.0


def test_a_variable_that_stands_still_is_not_tested(user_model, base):
    baseline = baseline_of(user_model, data_of(user_model, [base], [base]))
    names = {test.test.name for test in baseline.tests}
    assert "current" not in names and "mass" in names


def test_residuals_of_a_perfect_model_show_nothing(user_model, perfect):
    baseline = baseline_of(user_model, data_of(user_model, [perfect], [perfect]))
    np.testing.assert_allclose(force_rows(user_model, baseline.data.fit), targets(baseline.data.fit), atol=1e-6)


def test_a_channel_that_began_later_than_the_recording_still_counts(user_model, perfect):
    block = perfect.kinematics.block.copy()
    block[COMMAND, : block.shape[1] // 10] = np.nan
    late = replace(perfect, kinematics=replace(perfect.kinematics, block=block))
    names = {one.test.name for one in baseline_of(user_model, data_of(user_model, [late], [late]), base=()).tests}
    assert {"current", "temperature"} <= names
