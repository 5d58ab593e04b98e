"""Start points and knots come from the data."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.identification import LocalRows, Problem, rows_of
from damper_estimator.identification.knots import FEWEST, moved_knots, with_placed_knots
from damper_estimator.identification.start_points import MOST, SPREAD, candidates
from damper_estimator.model import load_model
from damper_estimator.signals.layout import A, V


@pytest.fixture
def recorded(measured):
    return measured(load_model("linear_viscous"))


def starts_of(model, recorded, seed=0):
    problem = Problem(model, LocalRows([rows_of(recorded)]), range(len(model.slots)))
    return problem, *candidates(problem, seed)


def test_the_models_values_come_first_and_all_keep_their_bounds(recorded):
    problem, points, size = starts_of(load_model("carrera_akutain"), recorded)
    np.testing.assert_array_equal(points[0], problem.start)
    low, high = problem.lower[problem.searched], problem.upper[problem.searched]
    assert ((points >= low) & (points <= high)).all() and (size > 0.0).all()
    assert len(points) == 2 + min(MOST, SPREAD * problem.searched.size)


def test_sizes_follow_from_units(entry, model_of, recorded):
    names = ("bouc_wen", "leak_blow_off_port", "tanh_hysteresis")
    problem, points, _ = starts_of(model_of(*(entry(name) for name in names)), recorded)
    centre = dict(zip((problem.model.slots[i].address for i in problem.searched), points[1], strict=True))
    force, velocity = recorded.force[recorded.judged].std(), recorded.kinematics.velocity[recorded.judged].std()
    assert centre["leak_blow_off_port.preload_rebound"] == pytest.approx(force)
    assert centre["leak_blow_off_port.spring_rebound"] == pytest.approx(force / velocity)
    assert centre["tanh_hysteresis.steepness"] == pytest.approx(1.0 / velocity)
    assert centre["tanh_hysteresis.shift"] == 0.0 and centre["bouc_wen.n"] == 1.5


def test_points_cover_the_range_and_the_seed_moves_them(recorded):
    _, first, _ = starts_of(load_model("memoryless_baseline"), recorded, seed=1)
    _, again, _ = starts_of(load_model("memoryless_baseline"), recorded, seed=1)
    _, other, _ = starts_of(load_model("memoryless_baseline"), recorded, seed=2)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    spread = np.sort(first[2:, 0])
    assert spread[-1] / spread[0] > 30.0 and (np.diff(np.log(spread)) < 1.5).all()


def test_default_knots_are_laid_over_the_velocities(recorded):
    model = with_placed_knots(load_model("viscous_curve"), [recorded])
    knots = np.array(model.effects[0].settings["velocity"])
    velocity = recorded.kinematics.velocity[recorded.judged]
    assert 0.0 in knots and (np.diff(knots) > 0.0).all()
    np.testing.assert_allclose(knots[[0, -1]], np.percentile(velocity, (0.5, 99.5)), rtol=1e-5)
    assert np.histogram(velocity, knots)[0].min() >= FEWEST
    assert len(model.effects[0].parameters["force"]) == knots.size
    assert moved_knots(load_model("viscous_curve"), model) == ["viscous_curve"]


def test_knots_without_enough_samples_are_left_out(recorded):
    fast = recorded.kinematics.block.copy()
    fast[V] = np.where(np.abs(fast[V]) < 0.02, 0.5, fast[V])
    kinematics = replace(recorded.kinematics, block=fast)
    model = with_placed_knots(load_model("viscous_curve"), [replace(recorded, kinematics=kinematics)])
    assert 2 < len(model.effects[0].settings["velocity"]) < 13


def test_given_knots_are_never_moved(entry, model_of, recorded):
    model = model_of(entry("viscous_curve", velocity=[-3.0, 0.0, 3.0]))
    assert with_placed_knots(model, [recorded]) == model


def test_a_curve_keeps_its_shape_where_its_knots_move(entry, model_of, recorded):
    line = entry("viscous_curve", force=[100.0 * v for v in entry("viscous_curve").settings["velocity"]])
    moved = with_placed_knots(model_of(entry("path", (line,))), [recorded]).effects[0].path[0]
    np.testing.assert_allclose(moved.parameters["force"], 100.0 * np.array(moved.settings["velocity"]), atol=1e-9)


def test_a_surface_is_laid_over_both_its_axes(entry, model_of, recorded):
    element = with_placed_knots(model_of(entry("force_surface")), [recorded]).effects[0]
    for name, row in (("velocity", V), ("acceleration", A)):
        values = recorded.kinematics.block[row, recorded.judged]
        np.testing.assert_allclose(
            np.array(element.settings[name])[[0, -1]], np.percentile(values, (0.5, 99.5)), rtol=1e-5
        )
    assert len(element.parameters["force"]) == len(element.settings["velocity"]) * len(element.settings["acceleration"])
