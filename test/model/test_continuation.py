"""Unknown points of a table continue from the nearest known ones, and never against the damping."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.model.continuation import Axis, continuation

VELOCITY = Axis(np.array([-1.5, -0.7, -0.3, -0.1, 0.0, 0.1, 0.3, 0.7, 1.5]), True)
CURRENT = Axis(np.array([0.0, 0.5, 1.0, 2.0]), False)
SIZE = VELOCITY.knots.size

forces = st.lists(st.floats(-3000.0, 3000.0), min_size=SIZE, max_size=SIZE).map(np.array)
known_points = st.lists(st.booleans(), min_size=SIZE, max_size=SIZE).filter(any).map(np.array)
told_at_current = st.lists(st.lists(st.booleans(), min_size=4, max_size=4), min_size=SIZE, max_size=SIZE).map(np.array)


def filled(axes, known, values):
    return (continuation(axes, known, values) @ values.ravel()).reshape(values.shape)


@given(known=known_points, values=forces)
def test_known_points_keep_their_values_and_the_others_do_not_matter(known, values):
    full = filled([VELOCITY], known, values)
    assert np.array_equal(full[known], values[known])
    assert np.array_equal(full, filled([VELOCITY], known, np.where(known, values, 1e6)))


@given(known=known_points, values=forces, offset=st.floats(-1000.0, 1000.0))
def test_an_offset_is_preserved(known, values, offset):
    shifted = filled([VELOCITY], known, values + offset)
    assert np.allclose(shifted, filled([VELOCITY], known, values) + offset, atol=1e-6)


@given(
    known=known_points.filter(lambda known: known.sum() > 1), slope=st.floats(0.0, 1e4), offset=st.floats(-500.0, 500.0)
)
def test_a_linear_damper_continues_linearly(known, slope, offset):
    values = offset + slope * VELOCITY.knots
    assert np.allclose(filled([VELOCITY], known, values), values, atol=1e-6)


@given(known=known_points, values=forces)
def test_outside_the_known_points_a_force_never_reverses_against_the_damping(known, values):
    values = np.abs(values) * np.sign(VELOCITY.knots)
    full = filled([VELOCITY], known, values)
    outside = np.arange(SIZE) < np.flatnonzero(known)[0], np.arange(SIZE) > np.flatnonzero(known)[-1]
    for side, sign in zip(outside, (-1.0, 1.0), strict=True):
        edge = np.flatnonzero(known)[0 if sign < 0.0 else -1]
        if VELOCITY.knots[edge] * sign > 0.0:
            assert (full[side] * sign >= 0.0).all()


@given(known=known_points, values=forces)
def test_a_rising_curve_keeps_rising(known, values):
    assert (np.diff(filled([VELOCITY], known, np.sort(values))) >= -1e-6).all()


@given(known=told_at_current.filter(np.any), values=forces)
def test_a_surface_independent_of_an_axis_continues_like_its_curve(known, values):
    full = filled([VELOCITY, CURRENT], known, np.repeat(values[:, None], 4, axis=1))
    curve = filled([VELOCITY], known.any(axis=1), values)
    assert np.allclose(full, curve[:, None], atol=1e-6)


def test_a_corner_has_the_value_of_its_velocity():
    known = np.zeros((SIZE, 4), bool)
    known[:, 0] = True
    known[3:6, 1] = True
    values = np.outer(VELOCITY.knots, [1000.0, 9000.0, 0.0, 0.0])
    full = filled([VELOCITY, CURRENT], known, values)
    assert full[-1].tolist() == [1500.0] * 4 and full[5, 3] == 900.0


def test_without_known_points_a_table_is_unchanged():
    values = np.arange(float(SIZE))
    assert np.array_equal(filled([VELOCITY], np.zeros(SIZE, bool), values), values)
