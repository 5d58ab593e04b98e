"""What is drawn of long signals: no peak is lost, marks hold what lies in them, sliders reach their bounds."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.studio.drawn_rows import CLOUD_CELLS, LINE_POINTS, Mark, cloud_rows, line_rows, span_of
from damper_estimator.studio.scale import from_place, to_place


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 1000), size=st.integers(1, 40_000), holes=st.booleans())
def test_no_peak_is_lost(seed, size, holes):
    draw = np.random.default_rng(seed)
    values = draw.standard_normal(size)
    values[draw.integers(0, size, 3)] *= 100.0
    if holes:
        values[draw.integers(0, size, max(size // 3, 1))] = np.nan
    rows = line_rows(values)
    assert rows.size <= LINE_POINTS + 2 and np.all(np.diff(rows) > 0)
    assert rows[0] == 0 and rows[-1] == size - 1
    if np.isfinite(values).any():
        assert np.nanmax(values[rows]) == np.nanmax(values)
        assert np.nanmin(values[rows]) == np.nanmin(values)


def test_a_cloud_keeps_its_outline():
    draw = np.random.default_rng(1)
    x, force = draw.standard_normal((2, 500_000))
    rows = cloud_rows(x, force)
    assert rows.size < 5000
    for values in (x, force):
        assert values[rows].max() == values.max() and values[rows].min() == values.min()


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000), size=st.integers(1, 60_000), lost=st.sampled_from([0.0, 0.5, 1.0]))
def test_a_cloud_has_few_points_and_those_that_there_are(seed, size, lost):
    draw = np.random.default_rng(seed)
    x, force = draw.standard_normal((2, size))
    force[draw.random(size) < lost] = np.nan
    rows = cloud_rows(x, force)
    assert rows.size <= CLOUD_CELLS[0] * CLOUD_CELLS[1] + 6 and np.all(np.diff(rows) > 0)
    assert np.isfinite(force[rows]).all()
    if np.isfinite(force).any():
        assert force[rows].max() == np.nanmax(force) and force[rows].min() == np.nanmin(force)


def test_a_span_has_a_neighbour_at_either_side():
    time = np.arange(10.0)
    assert span_of(time, 3.5, 5.5) == slice(3, 7)
    assert span_of(time, None, None) == slice(0, 10)
    assert span_of(time, 100.0, 200.0).stop - span_of(time, 100.0, 200.0).start >= 1


def test_a_mark_holds_what_lies_in_its_polygon():
    x, y = np.random.default_rng(2).uniform(-2.0, 2.0, (2, 5000))
    diamond = Mark("velocity", (1.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, -1.0))
    assert np.array_equal(diamond.inside(x, y), np.abs(x) + np.abs(y) < 1.0)
    assert np.array_equal(Mark("time", (-1.0, 1.0), (9.0, 9.0)).inside(x, y), np.abs(x) <= 1.0)


@given(low=st.floats(-1e6, 1e6), width=st.floats(1e-3, 1e9), where=st.floats(0.001, 0.999), place=st.floats(0.0, 1.0))
def test_a_slider_reaches_both_bounds_and_its_middle_is_the_value(low, width, where, place):
    high, centre = low + width, low + where * width
    assert from_place(0.0, centre, low, high) == low and np.isclose(from_place(1.0, centre, low, high), high)
    assert from_place(0.5, centre, low, high) == centre
    value = from_place(place, centre, low, high)
    assert low <= value <= high * (1 + 1e-12) or np.isclose(value, high)
    back = from_place(to_place(value, centre, low, high), centre, low, high)
    assert np.isclose(back, value, rtol=1e-6, atol=1e-6 * width)
