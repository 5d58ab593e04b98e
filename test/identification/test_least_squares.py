"""The search and the solving inside it, against independent ways to the same answer."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from damper_estimator.identification import LocalRows, Problem, rows_of
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.row_sources import Place
from damper_estimator.identification.unknowns import Unknowns

SAME = 1e-5  # of a parameter: two searches ended in the same place
COST = 1e-7  # of the cost


@pytest.fixture
def problems(entry, model_of, measured):
    """A small problem twice: with its linear parameters solved for, and the rows to search all of them."""
    truth = model_of(
        entry("tanh_hysteresis", force=400.0, steepness=50.0, shift=0.003),
        entry("viscous", rate=1800.0),
        entry("static_force", force=-40.0),
    )
    start = model_of(entry("tanh_hysteresis"), entry("viscous"), entry("static_force"))
    rows = rows_of(measured(truth, noise=0.05))
    return Problem(start, LocalRows([rows]), range(len(start.slots))), rows


def sums_of(problem):
    """What the problem's rows add up to, by themselves."""
    return problem.source.sums(Unknowns(problem.model, problem.given_free))


def test_solving_for_the_linear_parameters_equals_searching_for_all(problems):
    problem, rows = problems
    start = problem.model

    def residual(vector):
        return rows.of(start.with_vector(vector).force(rows.measurement.kinematics.block)) - rows.target

    point, converged = refine(problem, problem.start, np.array([30.0, 0.01]))
    bounds = (problem.lower, problem.upper)
    first = np.array([slot.value for slot in start.slots])
    full = least_squares(
        residual, first, bounds=bounds, x_scale=np.maximum(np.abs(first), 0.01), ftol=1e-14, xtol=1e-12, gtol=1e-12
    )
    assert converged
    assert point.cost == pytest.approx(full.cost, rel=COST)
    np.testing.assert_allclose(problem.vector(point.searched, point.solved), full.x, rtol=SAME)


def test_the_residual_of_a_point_is_what_the_whole_model_leaves(problems):
    problem, rows = problems
    point = problem.point(np.array([44.0, 0.001]))
    model = problem.model.with_vector(problem.vector(point.searched, point.solved))
    left = rows.of(model.force(rows.measurement.kinematics.block)) - rows.target
    near = sums_of(problem).near(Place(point.searched, point.solved, np.array([44.0, 0.01])))
    np.testing.assert_allclose(near[:, -1], left, atol=1e-8 * np.abs(rows.target).max())
    assert point.cost == pytest.approx(0.5 * np.sum(left**2))


def test_the_jacobian_is_the_derivative_with_the_linear_parameters_held(problems):
    problem, rows = problems
    point = problem.point(np.array([44.0, 0.001]))
    size = np.array([44.0, 0.01])
    near = sums_of(problem).near(Place(point.searched, point.solved, size))
    jacobian, reduced = near[:, :2], problem.linearised(point, size).reduced
    np.testing.assert_allclose(reduced.T @ reduced, near.T @ near, rtol=1e-9, atol=1e-9 * np.sum(near[:, -1] ** 2))
    block, values = rows.measurement.kinematics.block, problem.vector(point.searched, point.solved)
    for j, step in enumerate((1e-3, 1e-6)):
        plus, minus = values.copy(), values.copy()
        plus[problem.searched[j]] += step
        minus[problem.searched[j]] -= step
        central = (
            rows.of(problem.model.with_vector(plus).force(block))
            - rows.of(problem.model.with_vector(minus).force(block))
        ) / (2 * step)
        np.testing.assert_allclose(jacobian[:, j], central, atol=1e-3 * np.abs(central).max())


def test_a_start_without_a_finite_force_is_no_end(problems):
    problem, _ = problems
    point, converged = refine(problem, np.array([np.nan, 0.0]), np.array([30.0, 0.01]))
    assert not converged and point.cost == np.inf


def test_a_search_that_begins_with_steps_far_too_short_does_not_end_there(entry, model_of, measured):
    """What is gained within the first radius says nothing of a minimum beyond it."""
    truth = model_of(entry("viscous", rate=1800.0), entry("coulomb", force=300.0), entry("channel_skew", skew=0.004))
    start = model_of(entry("viscous"), entry("coulomb"), entry("channel_skew"))
    rows = rows_of(measured(truth))
    problem = Problem(start, LocalRows([rows]), range(len(start.slots)))
    point, _ = refine(problem, problem.start, np.array([1e-6]), 10, 1e-3)
    assert point.searched == pytest.approx([0.004], rel=0.02)
