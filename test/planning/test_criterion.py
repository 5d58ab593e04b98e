"""The criterion's laws: refitting takes away, steps add, repeats average noise alone."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.planning.criterion import Criterion, Pair, Weighing, decisive, sharpness
from damper_estimator.planning.search import chosen, repeated_one


def pair(rng, difference, columns, prior=1e-9, left=100.0):
    """A pair whose steps are given as rows: difference (s, r) and columns (s, r, k)."""
    k = columns.shape[-1]
    return Pair(
        0, 1, np.einsum("srk,srl->skl", columns, columns), np.einsum("srk,sr->sk", columns, difference)[..., None],
        np.sum(difference**2, axis=1)[:, None], prior * np.eye(k), 0.0, left,
    )  # fmt: skip


def remaining(compared, counts):
    """The difference that a refitted rival leaves, on the old recordings and the test."""
    held, each = compared.differences(counts)
    return held[0] + counts @ each[:, 0]


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def test_a_difference_that_the_rival_can_take_over_is_worth_nothing(rng):
    columns = rng.standard_normal((4, 50, 3))
    distinguished = pair(rng, columns @ np.array([1.0, -2.0, 0.5]), columns)
    assert remaining(distinguished, np.ones(4)) < 1e-6 * distinguished.square.sum()


def test_what_is_left_is_the_residual_of_least_squares(rng):
    columns, difference = rng.standard_normal((4, 50, 3)), rng.standard_normal((4, 50))
    told_apart = pair(rng, difference, columns)
    counts = np.array([1.0, 2.0, 0.0, 1.0])
    rows = np.repeat(np.arange(4), counts.astype(int))
    design, target = columns[rows].reshape(-1, 3), difference[rows].ravel()
    residual = target - design @ np.linalg.lstsq(design, target, rcond=None)[0]
    assert remaining(told_apart, counts) == pytest.approx(float(residual @ residual), rel=1e-6)


def test_more_steps_never_take_difference_away(rng):
    told_apart = pair(rng, rng.standard_normal((5, 40)), rng.standard_normal((5, 40, 4)), prior=2.0)
    counts, last = np.zeros(5), 0.0
    for step in (2, 0, 0, 4, 1):
        counts[step] += 1.0
        now = remaining(told_apart, counts)
        assert now >= last - 1e-9
        last = now


def test_knowledge_from_old_recordings_holds_the_rival_back(rng):
    difference, columns = rng.standard_normal((3, 40)), rng.standard_normal((3, 40, 6))
    free, held = (remaining(pair(rng, difference, columns, prior), np.ones(3)) for prior in (1e-6, 1e6))
    assert free < held <= np.sum(difference**2) * (1.0 + 1e-9)


def judge(compared, expected, form, noise, is_random=False):
    one = np.ones((1, compared.square.shape[0]))
    return Criterion((compared,), ("a", "b"), expected * one, form * one, noise * one, np.full(one.size, is_random))


def test_a_large_difference_is_decided_rightly_and_none_stays_a_tie(rng):
    columns = rng.standard_normal((1, 200, 2))
    for size, low, high in ((30.0, 0.99, 1.0), (1e-3, 0.0, 0.01)):
        judged = judge(pair(rng, size * rng.standard_normal((1, 200)), columns), 200.0, 0.5, 0.5)
        chances = judged.chances(np.ones(1))
        assert low <= chances.right <= high
        assert 0.0 <= chances.wrong <= 0.02 and chances.right + chances.wrong + chances.tied == pytest.approx(1.0)


def test_repeats_average_noise_but_not_what_the_form_gets_wrong(rng):
    columns, difference = rng.standard_normal((1, 200, 2)), 1.2 * rng.standard_normal((1, 200))
    counts = np.array([6.0])
    noisy, formed, random = (
        judge(pair(rng, difference, columns, left=1e-3), 200.0, *errors).chances(counts).right
        for errors in ((0.0, 8.0), (8.0, 0.0), (8.0, 0.0, True))
    )
    assert noisy > formed
    assert random == pytest.approx(noisy)  # another motion each time


def test_a_phenomenon_that_the_old_recordings_speak_against_is_confirmed_less_often(rng):
    columns, difference = rng.standard_normal((1, 200, 2)), 1.5 * rng.standard_normal((1, 200))
    rights = []
    for ahead in (1.5, 0.0, -1.5):
        compared = replace(pair(rng, difference, columns), ahead=ahead)
        rights.append(judge(compared, 200.0, 0.5, 0.5).chances(np.ones(1)).right)
    assert rights[0] > rights[1] > rights[2]


def test_what_a_diagnosis_charges_the_rival_helps_the_truth(rng):
    columns, difference = rng.standard_normal((1, 200, 2)), rng.standard_normal((1, 200))
    compared = pair(rng, difference, columns)
    plain, helped, hindered = (
        judge(replace(compared, charged=np.array([[ours], [theirs]])), 200.0, 0.5, 0.5).chances(np.ones(1)).right
        for ours, theirs in ((0.0, 0.0), (0.0, 60.0), (60.0, 0.0))
    )
    assert helped > plain > hindered


def test_without_a_step_everything_stays_tied(rng):
    judged = judge(pair(rng, rng.standard_normal((1, 200)), rng.standard_normal((1, 200, 2))), 200.0, 0.5, 0.5)
    assert judged.chances(np.zeros(1)).tied == pytest.approx(1.0)


def test_two_rivals_that_are_alike_are_beaten_together(rng):
    """The size of the error is one for both, so beating one is no second hurdle where that decides."""
    columns, difference = rng.standard_normal((1, 200, 2)), 0.9 * rng.standard_normal((1, 200))
    one = judge(pair(rng, difference, columns), 200.0, 1e-6, 1e-6).chances(np.ones(1)).right
    compared = (pair(rng, difference, columns), replace(pair(rng, difference, columns), rival=2))
    every = np.ones((3, 1))
    both = Criterion(compared, ("a", "b", "c"), 200.0 * every, 1e-6 * every, 1e-6 * every, np.zeros(1, bool))
    assert 0.1 < one < 0.9
    assert both.chances(np.ones(1)).right == pytest.approx(one, abs=0.02)


def test_the_mean_over_phenomena_weighs_each_by_its_probability(rng):
    columns = rng.standard_normal((1, 200, 2))
    clear, hidden = (pair(rng, size * rng.standard_normal((1, 200)), columns) for size in (30.0, 1e-3))
    one = np.ones((2, 1))
    both = Criterion(
        (clear, replace(hidden, truth=1, rival=0)), ("a", "b"), 200.0 * one, 0.5 * one, 0.5 * one, np.zeros(1, bool),
        {"a": 0.8, "b": 0.1},
    )  # fmt: skip
    chances = both.chances(np.ones(1))
    each = {name: right for name, right, _ in chances.by_truth}
    assert chances.right == pytest.approx((0.8 * each["a"] + 0.1 * each["b"]) / 0.9)


def test_the_factor_of_a_decision_follows_from_the_diagnosis():
    """Two independent recordings of equal weight: the test alone has to bring odds of nine."""
    assert decisive() == pytest.approx(np.log(9.0)) and sharpness() == pytest.approx(8.0 * 0.9)
    assert Weighing().ratio(decisive()) == pytest.approx(9.0 ** (1.0 / (8.0 * 0.9)), rel=1e-6)


@pytest.mark.parametrize("odds", [3.0, -3.0])
def test_of_two_recordings_each_adds_its_odds(odds):
    """What the old recordings say, and what the refit of the rival adds there, count like what the test says."""
    both = Weighing(before=1.0, after=2.0, weight=0.5)
    assert both.carried(odds, 1.0) == pytest.approx(odds)
    assert both.carried(odds, 1.3) == pytest.approx(odds + sharpness() * np.log(1.3))
    assert Weighing(1.0, 1.0, 0.5).carried(odds, 1.0) == pytest.approx(0.5 * odds), "the same motion counts once"


def test_the_search_finds_what_helps_and_keeps_to_the_time():
    worth, seconds = np.array([1.0, 5.0, 0.5, 4.0]), np.array([2.0, 3.0, 1.0, 2.5])

    def score(counts):
        return float(np.sum(worth * np.sqrt(counts)))

    found = chosen(score, seconds, 12.0, lambda counts: False, lambda text, share: None)
    counts = found.counts(4)
    assert counts @ seconds <= 12.0 and counts[1] >= 2 and counts[3] >= 2
    assert (counts % 2 == 0).all()  # the halves of the test are alike


def test_the_search_ends_where_nothing_more_is_needed():
    found = chosen(np.sum, np.ones(3), 100.0, lambda counts: counts.sum() >= 4, lambda text, share: None)
    assert len(found.order) == 2


def test_what_decides_is_driven_in_different_ways_first():
    """However much better one step is, and although it alone would be enough."""
    worth = np.array([100.0, 1.0, 0.5, 0.1, 0.0])

    def score(counts):
        return float(np.sum(worth * np.sqrt(counts)))

    found = chosen(score, np.ones(5), 100.0, lambda counts: True, lambda text, share: None, different=3)
    assert sorted(found.order) == [0, 1, 2]
    assert (
        len(set(chosen(score, np.ones(5), 8.0, lambda counts: False, lambda text, share: None, different=4).order)) == 4
    )


def test_a_test_that_nobody_splits_needs_no_halves():
    found = chosen(
        lambda counts: float(np.sum(np.sqrt(counts))), np.ones(3), 5.0, lambda counts: False, lambda text, share: None,
        parts=1,
    )  # fmt: skip
    assert found.counts(3).sum() == 5.0


def test_a_search_finds_its_way_where_a_short_test_is_worse_than_none():
    seconds, most = np.array([2.0, 3.0, 5.0]), 36.0

    def score(counts):
        return float(min(counts[1], 8.0) ** 2 - 10.0 * np.sqrt(counts.sum()))

    def never(counts):
        return False

    assert not chosen(score, seconds, most, never, lambda text, share: None).order
    first = repeated_one(score, seconds, most)
    assert first == (1,) * 6
    found = chosen(score, seconds, most, never, lambda text, share: None, first=first)
    assert found.counts(3)[1] >= 8.0 and found.counts(3) @ seconds <= most


def test_nothing_is_repeated_where_nothing_fits():
    assert repeated_one(np.sum, np.full(3, 9.0), 10.0) == ()
