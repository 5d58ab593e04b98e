"""Characteristic points and lines are found at their known positions."""

import numpy as np
import pytest
from shapes import SHAPES, branches, loop_of, two_lines

from damper_estimator.characterization.points import POINTS, characteristic_points

PEAK = 0.02 * 2.0 * np.pi * 2.0
KNEE = 0.02 * PEAK  # tolerance of a knee's speed


def test_points_follow_one_another_in_time(kind):
    points, _ = characteristic_points(loop_of(SHAPES[kind]))
    phases = [points[name].phase for name in "CDEFGHAB"]
    assert phases == sorted(phases)


@pytest.mark.parametrize(("kind", "rising", "falling"), [(1, 0.4, 0.4), (2, 0.6, 0.3), (6, 0.3, 0.6), (4, 0.1, 0.1)])
def test_yield_and_restoring_points_are_where_they_were_planted(kind, rising, falling):
    points, _ = characteristic_points(loop_of(SHAPES[kind]))
    assert points["D"].velocity == pytest.approx(rising * PEAK, abs=KNEE)
    assert points["F"].velocity == pytest.approx(falling * PEAK, abs=KNEE)
    assert points["H"].velocity == pytest.approx(-rising * PEAK, abs=KNEE)
    assert points["B"].velocity == pytest.approx(-falling * PEAK, abs=KNEE)
    assert points["D"].force == pytest.approx(SHAPES[kind](np.array([rising]), np.array([1.0]))[0], abs=50.0)


def test_type_3_has_its_restoring_point_nearer_to_rest_than_its_yield_point():
    points, _ = characteristic_points(loop_of(SHAPES[3]))
    assert abs(points["B"].velocity) < 0.5 * abs(points["H"].velocity)
    assert abs(points["B"].displacement) > abs(points["H"].displacement)


def test_return_and_reversal_points_are_at_the_extremes_of_the_motion(kind):
    points, _ = characteristic_points(loop_of(SHAPES[kind]))
    assert points["E"].velocity == pytest.approx(PEAK, rel=1e-6)
    assert points["A"].velocity == pytest.approx(-PEAK, rel=1e-6)
    assert points["C"].displacement == pytest.approx(-0.02)
    assert points["G"].displacement == pytest.approx(0.02)
    assert points["E"].force == pytest.approx(1000.0, rel=1e-6)


def test_without_a_knee_yield_restoring_and_return_are_one_point_and_lines_between_have_no_length():
    points, lines = characteristic_points(loop_of(SHAPES[0]))
    assert points["D"].phase == points["E"].phase == points["F"].phase
    assert all(np.isnan(lines[name].damping) for name in "aebf")
    assert all(lines[name].damping == pytest.approx(1000.0 / PEAK, rel=0.01) for name in "cdgh")


def test_lines_have_the_slopes_that_were_planted():
    _, lines = characteristic_points(loop_of(SHAPES[1]))
    for name in "cdgh":
        assert lines[name].damping == pytest.approx(700.0 / (0.4 * PEAK), rel=0.03)
    for name in "abef":
        assert lines[name].damping == pytest.approx(300.0 / (0.6 * PEAK), rel=0.05)


def test_only_a_direction_with_a_knee_has_one():
    knee, straight = two_lines(0.4, 700, 1000), two_lines(0.4, 400, 1000)
    digressive, linear = branches(knee, knee), branches(straight, straight)
    points, _ = characteristic_points(loop_of(lambda u, a: np.where(u > 0, digressive(u, a), linear(u, a))))
    assert points["D"].velocity == pytest.approx(0.4 * PEAK, abs=KNEE)
    assert points["H"].phase == points["A"].phase


def test_every_point_lies_on_the_loop(kind):
    loop = loop_of(SHAPES[kind], noise=0.01)
    points, _ = characteristic_points(loop)
    assert set(points) == set(POINTS)
    for point in points.values():
        nearest = np.min(np.hypot((loop.velocity - point.velocity) / PEAK, (loop.force - point.force) / 1000.0))
        assert nearest < 0.05  # half the distance of two phases on the steepest line
