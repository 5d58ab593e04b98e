"""Recordings judge one by one, and count by how much their motions differ."""

from dataclasses import replace

import numpy as np
import pytest
from planted import tried

from damper_estimator.diagnosis.by_recording import by_recording, independent
from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.diagnosis.evaluation import evaluated, remaining_of, without_effects
from damper_estimator.signals.layout import A, V, X


def renamed(measurement, name, size=1.0, away=0.0):
    """The recording under another name; its motion and force ``size`` times as large, its middle ``away`` (m)."""
    block = measurement.kinematics.block.copy()
    block[[X, V, A]] *= size
    block[X] += away
    kinematics = replace(measurement.kinematics, block=block)
    return replace(measurement, recording=name, kinematics=kinematics, force=size * measurement.force)


@pytest.fixture(scope="session")
def two(user_model, base):
    """Data of a recording and of one with a tenth of its motion and force."""
    pair = [base, renamed(base, "small", 0.1)]
    return data_of(user_model, pair, pair)


def test_windows_of_one_recording_are_one_judge(user_model, base):
    half = len(base.kinematics) // 2
    windows = [base.part(0, half), base.part(half, None)]
    data = data_of(user_model, windows, windows)
    assert by_recording(data.fit).weight == pytest.approx([1.0]) and independent(data.fit) == 1.0


def test_alone_a_recording_judges_by_its_sum_of_squares(noisy):
    ranked = evaluated(noisy, [tried(noisy, "coulomb", 0.6)], "kept")[0].evaluation
    assert ranked.error == pytest.approx(0.4**2)
    np.testing.assert_allclose(ranked.remaining.drawn, np.sqrt((1.0 - ranked.kept_gains) * 0.4**2))


def test_a_small_recording_counts_as_much_as_a_large_one(two, noisy):
    """What halves the squared error of the small one and leaves the other is worth the square root of a half."""
    rows = two.unseen_recordings.rows
    size = np.where(rows == 0, 1000.0, 100.0)
    before = with_residual(two, noisy, size)
    after = with_residual(two, noisy, np.where(rows == 0, 1000.0, 100.0 * np.sqrt(0.5)))
    left = remaining_of(two, after, before)
    assert left.error == pytest.approx(np.sqrt(0.5), rel=3e-3)
    assert left.unseen == pytest.approx(1.0, abs=0.01)


def test_what_is_small_beside_the_force_does_not_judge(two, noisy):
    """Thousand times the error of a recording that has next to none is no evidence."""
    rows = two.unseen_recordings.rows
    before, after = (with_residual(two, noisy, np.where(rows == 0, 1000.0, small)) for small in (1e-4, 1e-2))
    assert remaining_of(two, after, before).error == pytest.approx(1.0, abs=1e-3)


def with_residual(data, noisy, size):
    """Errors of both parts with residuals of the given sizes (r,)."""
    random = np.random.default_rng(3)
    sign = np.sign(random.standard_normal(size.size))
    baseline = replace(
        noisy, data=data, residual_fit=size * sign, residual_unseen=size * sign,
        **{name: np.zeros((size.size, 0)) for name in ("base_fit", "base_unseen", "found_fit", "found_unseen")},
    )  # fmt: skip
    return without_effects(baseline)[0]


def test_recordings_of_the_same_motion_count_once_and_of_different_ones_twice(user_model, base):
    same = data_of(user_model, [base, renamed(base, "again")], [base])
    assert same.independent == pytest.approx(1.0)
    other = data_of(user_model, [base, renamed(base, "small", 0.02)], [base])
    assert 1.5 < other.independent <= 2.0
    many = [renamed(base, f"{place}", 0.1, 0.1 * place) for place in range(5)]
    assert data_of(user_model, many, [base]).independent == 2.0


def test_a_short_recording_counts_less(user_model, base):
    short = renamed(base.part(0, round(5.0 * base.kinematics.rate)), "short")
    rows = data_of(user_model, [base, short], [base]).fit
    weight = by_recording(rows).weight
    seconds = [part.picks.size / part.rate for part in rows]
    assert weight[1] / weight[0] == pytest.approx(seconds[1] / min(seconds[0], 20.0))


def test_what_raises_the_error_of_one_of_two_recordings_is_contradicted(two, noisy):
    rows = two.unseen_recordings.rows
    before = with_residual(two, noisy, np.where(rows == 0, 1000.0, 500.0))
    after, little = (with_residual(two, noisy, np.where(rows == 0, 100.0, size)) for size in (550.0, 510.0))
    assert remaining_of(two, after, before).worsened == pytest.approx(0.5, abs=0.01)
    assert remaining_of(two, little, before).worsened == 0.0
    hypothesis = tried(noisy, "coulomb", 0.6)
    evaluation = evaluated(noisy, [hypothesis], "kept")[0].evaluation
    contradicted = replace(evaluation, remaining=remaining_of(two, after, before))
    assert "some of the recordings" in replace(hypothesis, evaluation=contradicted).exclusion
    assert not replace(hypothesis, evaluation=evaluation).exclusion
