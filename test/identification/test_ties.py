"""Points of curves and surfaces that the data do not reach follow those that they do, whatever fitted them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.identification import LocalRows, MethodOptions, Problem, fit, fit_joint, rows_of
from damper_estimator.identification.ties import Ties
from damper_estimator.identification.uncertainty import uncertainty
from damper_estimator.model import load_model
from damper_estimator.signals.layout import ROWS, A, V

KNOTS = [-1.2, -0.7, -0.4, -0.2, -0.08, 0.0, 0.08, 0.2, 0.4, 0.7, 1.2]
FAR = 3.0  # times the fastest sample: the range in which a curve is compared
NEAR = 2.0  # standard errors by which a determined point may move
SLIGHT = 0.005  # of the largest force that is determined: such a move matters to nobody


@pytest.fixture
def damper(entry, model_of):
    """A damper that continues straight beyond 0.2 m/s."""
    return model_of(entry("viscous_curve", velocity=[-0.2, 0.0, 0.2], force=[-700.0, 10.0, 500.0]))


@pytest.fixture
def curve(entry, model_of):
    """A curve with the knots of a data sheet and values that have nothing to do with the damper."""
    return model_of(entry("viscous_curve", velocity=KNOTS, force=[-900.0] * 4 + [0.0] * 3 + [900.0] * 4))


def steady(model, velocities):
    """Forces of a memoryless model, each velocity a separate start."""
    block = np.zeros((ROWS, len(velocities)))
    block[V] = velocities
    return model.force(block)


def tied(result):
    return {group[0] for group in result.undetermined if len(group) == 1}


def speed(*measurements):
    return max(float(np.abs(m.kinematics.velocity[m.judged]).max()) for m in measurements)


METHODS = {
    "least_squares": MethodOptions(),
    "hooke_jeeves": MethodOptions(),
    "genetic": MethodOptions(generations=2, population=8),
    "nsga2": MethodOptions(generations=2, population=8),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("effect", ["viscous_curve", "smooth_curve"])
def test_a_knot_that_the_data_do_not_reach_continues_those_that_they_do(
    entry, model_of, damper, measured, method, effect
):
    if method == "nsga2":
        recorded = [measured(damper, seed, rms=0.006 + 0.002 * seed, noise=0.02) for seed in (1, 2)]
    else:
        recorded = [measured(damper, 1, rms=0.008, noise=0.02)]
    model = model_of(entry(effect, velocity=KNOTS, force=[300.0] * len(KNOTS)))
    method_options = (
        METHODS[method]
        if method != "nsga2"
        else replace(METHODS[method], groups={"a": (recorded[0].recording,), "b": (recorded[1].recording,)})
    )
    result = fit(model, recorded, method=method, method_options=method_options)
    outer = [0, len(KNOTS) - 1]
    assert speed(*recorded) < 0.7
    assert {f"{effect}.force[{k}]" for k in outer} <= tied(result)
    force = [p.value for p in result.parameters]
    for k, inner in ((0, 1), (outer[1], outer[1] - 1)):
        slope = (force[k] - force[inner]) / (KNOTS[k] - KNOTS[inner])
        before = (force[inner] - force[2 * inner - k]) / (KNOTS[inner] - KNOTS[2 * inner - k])
        assert slope == pytest.approx(max(before, 0.0), rel=1e-6, abs=1e-6)
    wide = FAR * speed(*recorded) * np.array([-1.0, -0.6, 0.6, 1.0])
    assert (steady(result.model, wide) * wide > 0.0).all()


def test_the_straight_damper_is_found_far_outside(curve, damper, measured):
    recorded = measured(damper, 1, rms=0.01, noise=0.02)
    result = fit(curve, [recorded])
    wide = FAR * speed(recorded) * np.array([-1.0, -0.7, 0.7, 1.0])
    assert steady(result.model, wide) == pytest.approx(steady(damper, wide), rel=0.25)


def test_what_is_tied_has_no_standard_error_and_is_said(curve, damper, measured):
    result = fit(curve, [measured(damper, 1, rms=0.01)])
    names = tied(result)
    assert names and "viscous_curve.force[5]" not in names
    for p in result.parameters:
        assert np.isnan(p.standard_error) == (p.name in names) and not p.at_bound
    assert set(result.model.fit["standard_errors"]) == {p.name for p in result.parameters} - names
    assert any("do not reach" in said and all(name in said for name in names) for said in result.warnings)


def test_start_values_of_points_out_of_reach_do_not_matter(curve, damper, measured):
    recorded = measured(damper, 1, rms=0.01)
    values = [
        [p.value for p in fit(start, [recorded]).parameters] for start in (curve, curve.with_vector(np.full(11, -3e3)))
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-4, abs=0.1)


def test_a_fixed_point_is_never_tied_and_tells(curve, damper, measured):
    start = curve.with_values({"viscous_curve.force[10]": 4000.0})
    result = fit(start, [measured(damper, 1, rms=0.008)], fix=["viscous_curve.force[10]"])
    force = {slot.index: slot.value for slot in result.model.slots}
    assert force[10] == 4000.0 and "viscous_curve.force[9]" in tied(result)
    assert force[9] == pytest.approx(force[8] + (4000.0 - force[8]) * (0.7 - 0.4) / (1.2 - 0.4), rel=1e-6)


def test_each_setting_of_a_joint_fit_has_its_own_ties(curve, damper, measured):
    slow, fast = measured(damper, 1, rms=0.005), replace(measured(damper, 2, rms=0.02), recording="fast")
    joint = fit_joint(curve, [slow, fast], ["slow", "fast"], each=["viscous_curve.force"])
    names = tied(joint)
    assert {"viscous_curve.force[0]@slow", "viscous_curve.force[9]@slow"} <= names
    assert len([n for n in names if n.endswith("@fast")]) < len([n for n in names if n.endswith("@slow")])


def test_a_surface_keeps_damping_where_no_sample_came(entry, model_of, damper, measured):
    grid = {"velocity": [-1.5, -0.5, -0.1, 0.0, 0.1, 0.5, 1.5], "acceleration": [-100.0, -20.0, 0.0, 20.0, 100.0]}
    model = model_of(entry("force_surface", **grid, force=[-500.0] * 35))
    result = fit(model, [measured(damper, 1, rms=0.01, noise=0.02)])
    block = np.zeros((ROWS, 0))
    for v in (-3.0, -0.9, 0.9, 3.0):
        for a in (-200.0, -50.0, 0.0, 50.0, 200.0):
            column = np.zeros((ROWS, 1))
            column[V], column[A] = v, a
            block = np.hstack([block, column])
    assert (result.model.force(np.ascontiguousarray(block)) * block[V] > 0.0).all()
    assert len(tied(result)) >= 10


def test_a_parameter_without_influence_keeps_the_models_value_in_a_random_search(entry, model_of, damper, measured):
    model = model_of(entry("viscous", rate=2000.0), entry("end_stop", bump_position=-0.11, top_out_position=0.12))
    limits = {"end_stop.bump_position": (-0.5, -0.1), "end_stop.top_out_position": (0.1, 0.5)}
    recorded = measured(damper, 1, rms=0.003)
    result = fit(model, [recorded], method="genetic", method_options=METHODS["genetic"], limits=limits)
    values = {slot.address: slot.value for slot in model.slots}
    silent = {p.name: p.value for p in result.parameters if p.name.startswith("end_stop")}
    assert silent and silent == pytest.approx({name: values[name] for name in silent})


CURVES = st.builds(
    lambda below, above, slopes: (
        [*sorted({-round(v, 2) for v in below}), 0.0, *sorted({round(v, 2) for v in above})],
        slopes,
    ),
    st.lists(st.floats(0.03, 1.5), min_size=1, max_size=5),
    st.lists(st.floats(0.03, 1.5), min_size=1, max_size=5),
    st.lists(st.floats(500.0, 4000.0), min_size=12, max_size=12),
)


@settings(max_examples=30, deadline=None)
@given(knots=CURVES, rms=st.floats(0.003, 0.02), start=st.floats(-2000.0, 2000.0), seed=st.integers(0, 50))
def test_random_knots_obey_the_laws_of_ties(entry, model_of, measured, knots, rms, start, seed):
    velocity, slopes = knots
    steps = np.diff(velocity) * slopes[: len(velocity) - 1]
    force = np.concatenate([[0.0], np.cumsum(steps)])
    truth = model_of(entry("viscous_curve", velocity=velocity, force=(force - force[velocity.index(0.0)]).tolist()))
    model = model_of(entry("viscous_curve", velocity=velocity, force=[start] * len(velocity)))
    recorded = measured(truth, seed, seconds=8.0, rms=rms, noise=0.02)
    result = fit(model, [recorded])

    # Far outside the force still resists the motion.
    known = [k for k, p in enumerate(result.parameters) if p.name not in tied(result)]
    if len(known) > 2 and velocity[known[0]] < 0.0 < velocity[known[-1]]:
        wide = FAR * max(speed(recorded), *map(abs, velocity)) * np.array([-1.0, -0.7, 0.7, 1.0])
        assert (steady(result.model, wide) * wide > 0.0).all()

    # The same data twice change nothing.
    twice = fit(model, [recorded, replace(recorded, recording="again")])
    assert tied(twice) == tied(result)
    assert [p.value for p in twice.parameters] == pytest.approx(
        [p.value for p in result.parameters], rel=1e-5, abs=1e-2
    )

    # What the data determine stays where they put it.
    problem = Problem(model, LocalRows([rows_of(recorded)]), range(len(model.slots)))
    plain = problem.point(np.zeros(0))
    free = Ties((), np.eye(len(velocity)))
    error = uncertainty(problem, plain, problem.linearised(plain, np.zeros(0)), free).standard_error
    slight = SLIGHT * np.abs(plain.solved[known]).max(initial=0.0)
    for k in known:
        moved = abs(result.parameters[k].value - plain.solved[k])
        assert moved <= NEAR * error[k] + slight + 1e-6  # by noise, and by what was tied next to it


def test_a_speed_axis_is_laid_over_the_speeds_that_were_driven(entry, model_of, damper, measured):
    recorded = measured(damper, 1, rms=0.01)
    fitted = fit(model_of(entry("viscous", rate=2000.0), entry("direction_curve")), [recorded]).model
    knots = fitted.effects[1].settings["speed"]
    assert 0.0 < knots[0] and knots[-1] <= speed(recorded)


def test_the_library_model_does_not_reverse_beyond_the_recording(damper, measured):
    for seed in range(4):
        recorded = measured(damper, seed, rms=0.007 + 0.001 * seed, noise=0.05, command=0.0)
        fitted = fit(load_model("semi_active_yield"), [recorded], fix=["command_yield", "force_lag"]).model
        wide = np.array([-1.2, -0.7, 0.7, 1.2])
        curve = fitted.effects[0]
        assert (np.interp(wide, curve.settings["velocity"], curve.parameters["force"]) * wide > 0.0).all()
