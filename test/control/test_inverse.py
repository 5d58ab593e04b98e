"""The inverse of a model: the command for a desired force, for any model, motion and command."""

import numpy as np
import pytest
from commanded_models import (
    HIGHEST,
    LIBRARY,
    LOWEST,
    commanded_models,
    entry,
    model_of,
    random_commands,
    smooth_motion,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.control import InverseModel, influence
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, library_models, load_model
from damper_estimator.signals.layout import COMMAND, DT, TEMPERATURE, A, T, V, X

MODELS = commanded_models()
every_model = pytest.mark.parametrize("name", MODELS)


def force_after(model: DamperModel, past: np.ndarray, command: float, horizon: float, lead: float) -> float:
    """What the model gives after the last sample of ``past`` and one more, by running it from the start."""
    last = past[:, -1]
    ahead = last.copy()
    ahead[T], ahead[DT], ahead[COMMAND] = last[T] + horizon, horizon, command
    ahead[X] = last[X] + last[V] * lead + last[A] * lead**2 / 2.0
    ahead[V] = last[V] + last[A] * lead
    return float(model.force(np.column_stack([past, ahead]))[-1])


def driven(model: DamperModel, block: np.ndarray, horizon: float = 0.004, lead: float = 0.004) -> InverseModel:
    """An inverse after all samples except the last."""
    inverse = InverseModel(model, (LOWEST, HIGHEST), horizon, lead)
    for column in block[:, :-1].T:
        inverse.solve(column)
    return inverse


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    name=st.sampled_from(sorted(MODELS)),
    seed=st.integers(0, 10**6),
    size=st.integers(2, 60),
    speed=st.sampled_from([0.002, 0.02, 0.1, 0.3, 1.0]),
    command=st.floats(LOWEST, HIGHEST),
    horizon=st.sampled_from([0.001, 0.004, 0.02, 0.2]),
    lead=st.sampled_from([0.0, 0.002, 0.012]),
)
def test_the_inverse_of_the_forward_model_is_the_identity(name, seed, size, speed, command, horizon, lead):
    model = MODELS[name]
    block = smooth_motion(size, seed, speed)
    block[COMMAND] = random_commands(size, seed)
    wanted = force_after(model, block, command, horizon, lead)
    inverse = InverseModel(model, (LOWEST, HIGHEST), horizon, lead)
    intervals = [inverse.solve(column) for column in block[:, :-1].T]
    widest = max(one.force_max - one.force_min for one in intervals)
    answer = inverse.solve(block[:, -1], wanted)
    given_force = force_after(model, block, answer.current, horizon, lead)
    commands = np.linspace(LOWEST, HIGHEST, 21)
    forces = [force_after(model, block, c, horizon, lead) for c in commands]
    assert LOWEST <= answer.current <= HIGHEST
    assert answer.expected == pytest.approx(given_force, abs=1e-6 * (100.0 + abs(given_force)))
    # Where commands change next to nothing, nothing is the measure but the changes that they made before.
    slack = max(0.01 * np.ptp(forces), 0.001 * widest) + 1e-9 * abs(wanted)
    assert abs(given_force - wanted) <= slack
    assert answer.reached
    assert answer.force_min >= min(forces) - slack
    assert answer.force_max <= max(forces) + slack


@every_model
def test_it_needs_fewer_than_five_evaluations_of_the_model_per_sample(name):
    model, block = MODELS[name], smooth_motion(1500, 4)
    inverse = InverseModel(model, (LOWEST, HIGHEST))
    wanted = 0.7 * np.ptp(model.force(block)) * np.sin(11.0 * block[T]) + 900.0 * np.sign(block[V])
    answers = [inverse.solve(column, desired) for column, desired in zip(block.T, wanted, strict=True)]
    assert np.mean([answer.evaluations for answer in answers]) < 5.0
    # With reachable desired forces only, which need most evaluations.
    inverse.reset()
    random, spent, desired = np.random.default_rng(2), [], np.nan
    for column in block.T:
        answer = inverse.solve(column, desired)
        desired = random.uniform(answer.force_min, answer.force_max)
        spent.append(answer.evaluations)
    assert np.mean(spent) < 5.0


@every_model
def test_its_force_is_that_of_the_model_with_the_actual_commands(name):
    model, block = MODELS[name], smooth_motion(200, 5)
    block[COMMAND] = random_commands(200, 5)
    inverse = InverseModel(model, (LOWEST, HIGHEST))
    stream, alone = model.stream(), []
    given_forces = []
    for k, column in enumerate(block.T):
        given_forces.append(inverse.solve(column, 500.0 * np.sin(0.1 * k), slope=k % 3 == 0).force)
        alone.append(float(stream.force(column[:, None])[0]))
    assert given_forces == alone


def test_a_step_of_the_desired_force_drives_the_coil_to_its_limit_until_the_lag_has_settled():
    model = load_model("lozoya_santos_simple_symmetric")
    inverse = InverseModel(model, (LOWEST, HIGHEST), 0.004, 0.004)
    sample = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.0, np.nan, np.nan])
    steady = {c: model.force(np.tile(with_command(sample, c)[:, None], (1, 400)))[-1] for c in (0.4, 1.1)}
    answers = []
    for k in range(400):
        sample[DT], sample[COMMAND] = 0.002 * (k > 0), answers[-1].current if answers else 0.4
        answers.append(inverse.solve(sample, steady[0.4 if k < 100 else 1.1]))
    currents = np.array([answer.current for answer in answers])
    assert currents[90:100] == pytest.approx(0.4, abs=0.02)
    assert currents[100:103] == pytest.approx(HIGHEST)
    assert not answers[101].reached
    assert currents[-20:] == pytest.approx(1.1, abs=0.02)
    # Without the push the lag of 25 ms would take 80 ms to come as near.
    assert next(k for k in range(100, 400) if answers[k].reached) < 110 + 0.025 / 0.002


def with_command(sample: np.ndarray, command: float) -> np.ndarray:
    changed = sample.copy()
    changed[COMMAND], changed[DT] = command, 0.01
    return changed


@every_model
def test_trials_do_not_change_the_state(name):
    """Desired forces change the command, never the state of the model."""
    model, block = MODELS[name], smooth_motion(120, 6)
    block[COMMAND] = random_commands(120, 6)
    busy, idle = InverseModel(model, (LOWEST, HIGHEST)), InverseModel(model, (LOWEST, HIGHEST))
    for k, column in enumerate(block.T):
        one = busy.solve(column, 2000.0 * np.sin(k), slope=True)
        other = idle.solve(column)
        assert one.force == other.force
        assert np.isnan(other.current)


def test_slopes_are_those_of_the_force():
    model = MODELS["parallel to friction with memory"]
    block = smooth_motion(50, 8)
    block[COMMAND] = random_commands(50, 8)
    answer = driven(model, block).solve(block[:, -1], force_after(model, block, 1.2, 0.004, 0.004), slope=True)
    near = [force_after(model, block, answer.current + d, 0.004, 0.004) for d in (-1e-3, 1e-3)]
    assert answer.dforce_dcurrent == pytest.approx((near[1] - near[0]) / 2e-3, rel=0.05)
    faster = block.copy()
    faster[V, -1] += 1e-3
    faster[X, -1] -= 1e-3 * 0.004
    slope = (force_after(model, faster, answer.current, 0.004, 0.004) - answer.expected) / 1e-3
    assert answer.dforce_dvelocity == pytest.approx(slope, rel=0.05)


def test_a_lead_is_as_good_as_later_kinematics():
    model = MODELS["without a lag"]
    block = smooth_motion(30, 9)
    wanted = force_after(model, block, 0.8, 0.004, 0.01)
    assert driven(model, block, 0.004, 0.01).solve(block[:, -1], wanted).current == pytest.approx(0.8, abs=0.02)


def test_a_force_inside_a_dip_is_found_and_one_below_it_gets_the_bottom():
    """At 0 A the force is that of oil; a little current lowers it, more raises it."""
    model = MODELS["against the spring"]
    block = smooth_motion(30, 9)
    block[X, -1], block[V, -1], block[A, -1] = -0.03, 0.08, 0.0
    forces = {c: force_after(model, block, c, 0.004, 0.004) for c in np.linspace(LOWEST, HIGHEST, 201)}
    bottom = min(forces, key=forces.get)
    assert 0.1 < bottom < 1.9
    deep = min(forces.values())
    inside = driven(model, block).solve(block[:, -1], 0.5 * (deep + min(forces[LOWEST], forces[HIGHEST])))
    assert inside.reached
    below = driven(model, block).solve(block[:, -1], deep - 500.0)
    assert not below.reached
    assert below.current == pytest.approx(bottom, abs=0.1)
    assert below.expected == pytest.approx(deep, abs=0.01 * (max(forces.values()) - deep))


def test_a_force_out_of_reach_gets_only_as_much_current_as_helps():
    """Near a reversal the command has little effect, and a slow coil would keep its field afterwards."""
    inverse = InverseModel(MODELS["without a lag"], (LOWEST, HIGHEST), 0.004, 0.0)
    sample = np.array([0.0, 0.0, 0.0, 1.0, 0.0, np.nan, np.nan, np.nan])
    assert inverse.solve(sample, 1e5).current == HIGHEST
    sample[DT], currents = 0.002, []
    for speed in (0.5, 0.004, 0.002, 0.001):
        sample[V] = speed
        assert inverse.solve(sample, -1e5).current == LOWEST
        answer = inverse.again(1e5)
        currents.append(answer.current)
        assert not answer.reached
        assert answer.force_min < answer.expected <= answer.force_max
    assert currents[0] == HIGHEST
    assert HIGHEST > currents[1] > currents[2] > currents[3] > LOWEST


def test_where_no_command_changes_the_force_the_last_one_is_kept():
    """At standstill the yield force has no sign; any command gives the same force, so it must not chatter."""
    model = MODELS["without a lag"]
    inverse = InverseModel(model, (LOWEST, HIGHEST))
    sample = np.array([0.0, 0.0, 0.0, 0.3, 0.0, np.nan, np.nan, np.nan])
    moving = inverse.solve(sample, 500.0)
    assert moving.reached
    sample[V], sample[DT] = 0.0, 0.002
    still = inverse.solve(sample, 0.0)
    assert still.reached
    assert still.current == moving.current
    assert not inverse.solve(sample, 300.0).reached


@pytest.mark.parametrize("is_trusted", [True, False])
def test_a_wild_sample_that_is_not_trusted_does_not_freeze_the_command(is_trusted):
    """The command is kept where its influence is a small share of the largest one; a glitch is no measure of that."""
    model = model_of(entry("viscous", rate=800.0), entry("command_gain", rest=0.3, bend=1.0))
    inverse = InverseModel(model, (LOWEST, HIGHEST))
    sample = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 1.0, np.nan, np.nan])
    inverse.solve(sample)
    sample[V], sample[DT] = 3e5, 0.002
    inverse.solve(sample, is_trusted=is_trusted)
    sample[V] = 0.3
    reach = inverse.solve(sample)
    between = np.linspace(reach.force_min, reach.force_max, 5)
    assert (np.ptp([inverse.again(wanted).current for wanted in between]) > 0.0) != is_trusted


def test_a_gap_resets_the_model():
    model = MODELS["parallel to friction with memory"]
    block = smooth_motion(60, 3)
    block[COMMAND] = random_commands(60, 3)
    inverse, late = InverseModel(model, (LOWEST, HIGHEST)), InverseModel(model, (LOWEST, HIGHEST))
    block[DT, 30] = 0.0
    through = [inverse.solve(column).force for column in block.T]
    assert through[30:] == [late.solve(column).force for column in block[:, 30:].T]
    inverse.reset()
    assert [inverse.solve(column).force for column in block.T] == through


def test_a_force_that_is_not_finite_has_no_command_and_affects_only_its_sample():
    model = model_of(entry("viscous"), entry("semi_active_squash"), entry("temperature_gain"))
    block = smooth_motion(20, 3)
    block[COMMAND], block[TEMPERATURE] = 1.0, 50.0
    inverse = InverseModel(model, (LOWEST, HIGHEST))
    bad = block[:, 0].copy()
    bad[V] = np.nan
    answer = inverse.solve(bad, 100.0)
    assert np.isnan(answer.current)
    assert not answer.reached
    good = [inverse.solve(column, 100.0) for column in block.T]
    assert np.isfinite([answer.current for answer in good]).all()
    assert good[5].force == float(model.force(block[:, :6])[-1])


@pytest.mark.parametrize("name", [name for name in library_models() if name not in LIBRARY])
def test_models_without_a_command_are_refused_with_the_reason(name):
    with pytest.raises(InputError, match=f"model {name}: its force does not depend on the command") as refusal:
        InverseModel(load_model(name), (LOWEST, HIGHEST))
    assert "\n" not in str(refusal.value)


def test_a_command_without_influence_between_the_limits_is_refused_by_behaviour():
    silent = model_of(entry("viscous"), entry("semi_active_squash", gain=0.0))
    with pytest.raises(InputError, match="does not depend on the command"):
        InverseModel(silent, (LOWEST, HIGHEST))
    assert influence(silent, LOWEST, HIGHEST) == 0.0
    assert influence(MODELS["without a lag"], LOWEST, HIGHEST) > 100.0


def test_limits_come_from_the_fit_or_must_be_given():
    model = MODELS["without a lag"]
    with pytest.raises(InputError, match="give the lowest and the highest command"):
        InverseModel(model)
    fitted = DamperModel(model.name, model.source, model.effects, fit={"region": {"command": [0.1, 1.6]}})
    assert InverseModel(fitted).limits == (0.1, 1.6)
    with pytest.raises(InputError, match="are not a range"):
        InverseModel(model, (2.0, 0.0))


def test_effects_of_the_measurement_chain_are_refused():
    model = model_of(entry("viscous"), entry("semi_active_squash"), entry("force_offset"))
    with pytest.raises(InputError, match="measurement chain"):
        InverseModel(model, (LOWEST, HIGHEST))


def test_another_desired_force_at_the_same_sample_uses_the_same_state():
    for name in ("semi_active_on_mount", "parallel to friction with memory"):
        repeated, single = InverseModel(MODELS[name], (LOWEST, HIGHEST)), InverseModel(MODELS[name], (LOWEST, HIGHEST))
        block = smooth_motion(300, 11)
        for k, column in enumerate(block.T):
            wanted = 600.0 * np.sin(0.1 * k)
            first, answer = repeated.solve(column, slope=True), repeated.again(wanted)
            direct = single.solve(column, wanted)
            assert (answer.current, answer.force, answer.expected) == (direct.current, direct.force, direct.expected)
            assert answer.evaluations == direct.evaluations - 1 and np.isnan(first.current)
