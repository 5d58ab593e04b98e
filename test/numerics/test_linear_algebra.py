"""Least squares: triangles, bounds, damped steps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from damper_estimator.numerics import bounded_least_squares, damped_step, least_squares, normal_equations, triangle

RIDGE = 1e-5  # of a parameter: what the ridge may move on well-conditioned columns


@pytest.fixture
def random():
    return np.random.default_rng(7)


@pytest.mark.parametrize("rows", [3, 8, 500, 5003, 30000])
def test_a_triangle_keeps_all_that_a_matrix_says(rows, random):
    matrix = random.standard_normal((rows, 5)) * [1.0, 1e3, 1e-3, 1.0, 1.0]
    reduced = triangle(matrix)
    assert len(reduced) == min(rows, 5)
    np.testing.assert_allclose(reduced.T @ reduced, matrix.T @ matrix, rtol=1e-10, atol=1e-12 * rows)


def test_triangles_of_parts_have_the_triangle_of_the_whole(random):
    matrix = random.standard_normal((900, 4))
    parts = np.concatenate([triangle(part) for part in np.split(matrix, [200, 350])])
    np.testing.assert_allclose(np.abs(triangle(parts)), np.abs(triangle(matrix)), rtol=1e-12)


@given(st.integers(0, 999), st.integers(1, 6), st.integers(8, 40))
@settings(max_examples=50, deadline=None)
def test_bounded_linear_least_squares_agrees_with_scipys(seed, count, size):
    random = np.random.default_rng(seed)
    columns = random.standard_normal((size, count)) * 10.0 ** random.integers(-4, 5, count)
    target = random.standard_normal(size)
    free = np.linalg.lstsq(columns, target, rcond=None)[0]
    lower = np.where(random.uniform(size=count) < 0.5, -np.abs(free) * random.uniform(0.1, 3.0, count), -1e6)
    upper = -0.3 * lower
    found = bounded_least_squares(columns, target, lower, upper, np.zeros(count))
    best = lsq_linear(columns, target, (lower, upper), method="bvls", tol=1e-14).x
    assert (found >= lower).all() and (found <= upper).all()
    cost, best_cost = (np.sum((columns @ p - target) ** 2) for p in (found, best))
    assert cost <= best_cost * (1.0 + RIDGE) + 1e-18


def test_what_the_data_do_not_determine_stays_at_the_reference():
    column = np.linspace(0.0, 1.0, 50)
    columns = np.column_stack([column, np.zeros(50), column])
    found = bounded_least_squares(
        columns, 6.0 * column, np.full(3, -100.0), np.full(3, 100.0), np.array([1.0, 7.0, 3.0])
    )
    np.testing.assert_allclose(found, [2.0, 7.0, 4.0], rtol=RIDGE)


def test_normal_equations_in_pieces_are_those_of_the_whole(random):
    columns, target = random.standard_normal((1000, 7)), random.standard_normal(1000)
    normal, right = normal_equations(columns, target)
    np.testing.assert_allclose(normal, columns.T @ columns, rtol=1e-12, atol=1e-10)
    np.testing.assert_allclose(right, columns.T @ target, rtol=1e-12, atol=1e-10)
    solution, inverse = least_squares(columns, target)
    np.testing.assert_allclose(solution, np.linalg.lstsq(columns, target, rcond=None)[0], rtol=1e-6)
    np.testing.assert_allclose(inverse, np.linalg.inv(columns.T @ columns), rtol=1e-6)


def test_a_damped_step_is_a_gauss_newton_step_with_a_penalty(random):
    columns, residual = random.standard_normal((300, 4)), random.standard_normal(300)
    held = np.sqrt(np.mean(residual**2)) / 0.3 * np.eye(4)
    expected = np.linalg.lstsq(np.vstack([columns, held]), np.concatenate([-residual, np.zeros(4)]), rcond=None)[0]
    np.testing.assert_allclose(damped_step(columns, residual, 0.3), expected, rtol=1e-9)


def test_a_damped_step_leaves_what_has_no_influence(random):
    columns = random.standard_normal((300, 3)) * [1.0, 0.0, 1.0]
    assert damped_step(columns, random.standard_normal(300), 0.3)[1] == 0.0


def test_a_damped_step_ends_at_the_solution(random):
    columns = 100.0 * random.standard_normal((300, 3))
    residual = columns @ [0.1, -0.05, 0.02]
    np.testing.assert_allclose(damped_step(columns, residual, 1.0), [-0.1, 0.05, -0.02], rtol=1e-3)


def test_a_damped_step_is_found_with_many_columns_alike(random):
    # Some versions of LAPACK's divide-and-conquer SVD do not converge on such matrices.
    columns = np.repeat(random.standard_normal((300, 2)) * [1.0, 200.0], [3, 15], axis=1)
    residual = random.standard_normal(300)
    step = damped_step(columns, residual, 0.03)
    # Columns that are alike share one step.
    np.testing.assert_allclose(step, np.repeat(step[[0, 3]], [3, 15]), rtol=1e-6)
    held = np.sqrt(np.mean(residual**2)) / 0.03
    gradient = columns.T @ (residual + columns @ step) + held**2 * step
    np.testing.assert_allclose(gradient, np.zeros(18), atol=1e-6 * np.abs(columns.T @ residual).max())
    assert not damped_step(columns, np.zeros(300), 0.03).any()
