"""Delayed samples are detected; different clocks are no fault of the samples."""

import numpy as np

from damper_estimator.node.stamp_age import RELATED, StampAge

NOW = 1_700_000_000 * 10**9
SECOND = 10**9


def judged(stamps, arrivals, max_age=0.5):
    age = StampAge()
    return np.array([age.is_late(int(s), int(a), max_age) for s, a in zip(stamps, arrivals, strict=True)]), age


def test_delayed_samples_are_late_from_the_first_one_on():
    stamps = NOW + np.arange(100) * SECOND // 100
    late, age = judged(stamps, stamps + 3 * SECOND)
    assert late.all() and age.late == 100 and age.is_related
    assert not judged(stamps, stamps + SECOND // 10)[0].any()


def test_a_queue_that_waited_during_a_stall_is_late_until_it_is_processed():
    stamps = NOW + np.arange(2000) * SECOND // 100
    arrivals = stamps + SECOND // 1000
    arrivals[500:800] = arrivals[800]
    late, _ = judged(stamps, arrivals)
    assert late[500:700].all() and not late[:500].any() and not late[760:].any()


def test_stamps_ahead_of_this_clock_are_judged_against_the_youngest():
    stamps = NOW + np.arange(1000) * SECOND // 100
    arrivals = stamps - 5 * SECOND
    arrivals[600:] += 2 * SECOND
    late, _ = judged(stamps, arrivals)
    assert not late[:600].any() and late[600:].all()


def test_a_clock_that_was_ahead_for_a_while_makes_no_later_sample_late():
    times = NOW + np.arange(3000) * SECOND // 100
    stamps = times.copy()
    stamps[500:600] += 2 * SECOND
    late, _ = judged(stamps, times + SECOND // 1000)
    assert not late.any()


def test_one_lagging_sender_of_two_is_always_late():
    times = NOW + np.arange(2000) * SECOND // 100
    stamps = times.copy()
    stamps[1::2] -= 3 * SECOND
    late, _ = judged(stamps, times)
    assert late[1::2].all() and not late[::2].any()


def test_stamps_of_another_time_are_not_judged_at_any_pace():
    stamps = np.arange(1000) * SECOND // 1000
    late, age = judged(stamps, NOW + np.arange(1000) * SECOND)
    assert not late.any() and not age.is_related
    assert abs(age.age) > RELATED


def test_a_restarted_recording_and_a_drifting_clock_are_no_delay():
    once = np.arange(3000) * SECOND // 10
    stamps = np.concatenate([NOW + once, NOW + once])
    late, _ = judged(stamps, NOW + np.arange(6000) * SECOND // 10)
    assert not late[:3000].any()
    hours = NOW + np.arange(0, 7200) * SECOND
    drifting = hours + 2 * SECOND - (np.arange(7200) * 100_000)  # 100 ppm, from 2 s ahead
    assert not judged(drifting, hours)[0].any()


def test_without_a_maximum_age_nothing_is_judged():
    assert not judged([NOW], [NOW + 100 * SECOND], 0.0)[0].any()


def test_the_fastest_sample_follows_a_small_step_of_the_clock_within_a_second_but_not_a_pause():
    age, now = StampAge(), 10**18
    for _ in range(500):
        age.is_late(now - 5_000_000, now, 0.5)
        now += 2_000_000
    for _ in range(500):  # the sender's clock is set back by 50 ms
        age.is_late(now - 55_000_000, now, 0.5)
        now += 2_000_000
    assert 0.05 < age.fastest <= 0.055 + 1e-9
    now += 2_000_000_000  # no message for two seconds, then all at once
    age.is_late(now - 2_000_000_000, now, 0.5)
    assert age.fastest < 0.07


def test_a_sample_that_overtakes_the_simulated_clock_does_not_affect_later_ones():
    stamps = 1000 * SECOND + np.arange(1000) * SECOND // 100
    stamps[300:] += SECOND
    clock = stamps.copy()
    clock[0], clock[300] = 0, stamps[299]
    age = StampAge()
    late = [age.is_late(int(s), int(c), 0.5, is_simulated=True) for s, c in zip(stamps, clock, strict=True)]
    assert not any(late) and age.is_related and age.fastest == 0.0
    assert age.is_late(int(stamps[-1]), int(stamps[-1]) + SECOND, 0.5, is_simulated=True)
