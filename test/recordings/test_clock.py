"""Times of bench files: rounding is undone, real unevenness is kept."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.errors import InputError
from damper_estimator.recordings.clock import EPOCH, even_steps, read_times
from damper_estimator.recordings.column_map import Clock, TextFormat
from damper_estimator.recordings.text_table import TextTable

DIGIT = 1e-4


def times_of(cells, **clock):
    text = "t;x\n" + "\n".join(f"{cell};0" for cell in cells)
    named = ["t"] if "format" in clock else []
    needed = ["x"] if named else ["t", "x"]
    return read_times(
        TextTable(Path("bench.csv"), text.encode(), TextFormat(), needed, named), Clock(column="t", **clock)
    )


def test_a_rate_of_3005_hz_printed_with_four_decimals_is_recovered():
    printed = times_of([f"{row / 3005:.4f}" for row in range(30050)])
    steps = np.diff(printed.seconds)
    assert steps.max() - steps.min() < 1e-9
    assert 1 / steps.mean() == pytest.approx(3005, rel=DIGIT / 10)  # two ends, each off by a digit, over 10 s


@settings(max_examples=60, deadline=None)
@given(st.floats(20, 5000), st.integers(10, 2000), st.floats(-100, 100), st.booleans())
def test_rounded_and_cut_off_even_times_become_even(rate, count, start, cut):
    exact = start + np.arange(count) / rate
    printed = np.floor(exact / DIGIT) * DIGIT if cut else np.round(exact, 4)
    even = even_steps(printed, DIGIT)
    assert np.abs(even - exact).max() <= 1.01 * DIGIT
    if 1 / rate > 2 * DIGIT:
        assert np.ptp(np.diff(even)) < 1e-9


def test_uneven_times_stay_unchanged():
    jittered = np.arange(1000) * 1e-3 + np.random.default_rng(0).uniform(-2e-4, 2e-4, 1000)
    assert (even_steps(jittered, 1e-6) == jittered).all()


def test_a_pause_does_not_bend_the_grid_on_either_side():
    exact = np.arange(3000) / 3005
    exact[1500:] += 10.0
    even = even_steps(np.round(exact, 4), DIGIT)
    for run in (even[:1500], even[1500:]):
        assert np.ptp(np.diff(run)) < 1e-9
    assert even[1500] - even[1499] > 9.99


def test_exact_times_stay_exact():
    exact = np.arange(100) * 0.005
    assert even_steps(exact, 0.0) == pytest.approx(exact, abs=1e-15)


def test_dates_are_utc():
    first = datetime(2022, 5, 13, 17, 0, 29, 714000, UTC)
    cells = [(first + timedelta(milliseconds=row)).strftime("%m/%d/%Y %I:%M:%S.%f %p") for row in range(50)]
    read = times_of(cells, format="%m/%d/%Y %I:%M:%S.%f %p")
    stamps = read.stamps(slice(0, 50))
    exact = int(first.timestamp()) * 10**9 + 714_000_000 + np.arange(50) * 1_000_000
    assert np.abs(stamps - exact).max() <= 1_000  # ns; seconds since 1970 are doubles


def test_unix_times_are_kept_and_others_are_dated():
    assert times_of(["1652461229.5", "1652461230.5"]).stamps(slice(0, 2))[0] == 1652461229_500_000_000
    assert times_of(["0.5", "1.5"]).stamps(slice(0, 2)).tolist() == [
        EPOCH * 10**9 + 500_000_000,
        EPOCH * 10**9 + 1_500_000_000,
    ]


def test_units_of_time_convert():
    assert times_of(["0", "5", "10"], unit="ms").seconds.tolist() == [0.0, 0.005, 0.01]


@pytest.mark.parametrize(
    ("cells", "clock", "complaint"),
    [
        (["0", "late", "2"], {}, "1 times of column 't' are no numbers"),
        (["13.05.2022", "05/14/2022"], {"format": "%d.%m.%Y"}, "row 2: '05/14/2022' is no date of the form '%d.%m.%Y'"),
    ],
)
def test_invalid_times_are_refused(cells, clock, complaint):
    with pytest.raises(InputError, match=complaint):
        times_of(cells, **clock)
