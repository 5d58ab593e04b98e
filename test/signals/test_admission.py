"""The samples that a filter can use: equal, older, missing and broken ones."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.compiled import plain
from damper_estimator.signals.admission import (
    ACCEPTED,
    DUPLICATE,
    GAP,
    INVERSION,
    NON_FINITE,
    START,
    STEP_BACK,
    Admission,
    Counts,
    judge,
)

MS = 1_000_000


def verdicts(stamps_ms, values=None, max_gap=0.1):
    stamp = np.array(stamps_ms, np.int64) * MS
    value = np.zeros(stamp.size) if values is None else np.array(values, float)
    return Admission(max_gap).block(stamp, value)


def test_equal_and_older_stamps_are_dropped():
    verdict, _ = verdicts([0, 10, 10, 5, 20])
    assert verdict.tolist() == [START, ACCEPTED, DUPLICATE, INVERSION, ACCEPTED]


def test_a_step_counts_from_the_last_accepted_sample():
    _, dt = verdicts([0, 10, 5, 30])
    assert dt[[1, 3]].tolist() == [0.01, 0.02]


def test_gaps_and_steps_back_beyond_the_limit_are_new_starts():
    verdict, dt = verdicts([0, 100, 201, 301, 200, 210])
    assert verdict.tolist() == [START, ACCEPTED, GAP, ACCEPTED, STEP_BACK, ACCEPTED]
    assert dt[[0, 2, 4]].tolist() == [0.0, 0.0, 0.0]


def test_values_that_are_not_finite_are_dropped_and_leave_no_trace():
    verdict, dt = verdicts([0, 10, 20, 30], [0.0, np.nan, np.inf, 1.0])
    assert verdict.tolist() == [START, NON_FINITE, NON_FINITE, ACCEPTED]
    assert dt[3] == 0.03


def test_counts_add_up():
    verdict, _ = verdicts([0, 10, 10, 5, 300, 20, 30], [0, 0, 0, 0, 0, 0, np.nan])
    counts = Counts.of(verdict)
    assert counts == Counts(7, starts=1, gaps=1, steps_back=1, duplicates=1, inversions=1, non_finite=1)
    assert counts + counts == Counts(14, 2, 2, 2, 2, 2, 2)
    assert counts.dropped == 3


@given(st.lists(st.tuples(st.integers(-300, 600), st.sampled_from([0.0, np.nan])), min_size=1, max_size=60), st.data())
@settings(max_examples=60, deadline=None)
def test_any_split_gives_the_same_verdicts_and_accepted_steps_are_positive(samples, data):
    stamp = np.cumsum([s for s, _ in samples]).astype(np.int64) * MS
    value = np.array([v for _, v in samples])
    whole, dt = Admission(0.1).block(stamp, value)
    cut = data.draw(st.integers(0, len(samples)))
    stream = Admission(0.1)
    parts = [stream.block(stamp[:cut], value[:cut]), stream.block(stamp[cut:], value[cut:])]
    assert np.array_equal(whole, np.concatenate([p[0] for p in parts]))
    assert np.array_equal(dt, np.concatenate([p[1] for p in parts]))
    accepted = whole == ACCEPTED
    assert (dt[accepted] > 0.0).all() and (dt[accepted] <= 0.1).all()
    assert not dt[~accepted].any()


def test_compiled_equals_plain_python():
    random = np.random.default_rng(2)
    stamp = np.cumsum(random.integers(-20, 60, 500)) * MS * 5
    value = np.where(random.random(500) < 0.05, np.nan, 0.0)
    results = []
    for function in (judge, plain(judge)):
        verdict, dt = np.empty(500, np.int64), np.empty(500)
        function(stamp, value, 100 * MS, np.zeros(2, np.int64), verdict, dt)
        results.append((verdict, dt))
    assert np.array_equal(results[0][0], results[1][0]) and np.array_equal(results[0][1], results[1][1])
