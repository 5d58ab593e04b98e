"""Rest and motion in a displacement."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from damper_estimator.recordings.bench_rest import find_motion, middle_position, rest_position

RATE = 500.0


def stroke(before: int, after: int, frequency: float, noise: float, quantum: float, seed: int = 0) -> np.ndarray:
    cycles = np.arange(int(5 * RATE / frequency)) / RATE
    motion = np.sin(2 * np.pi * frequency * cycles)
    position = 30.0 + np.concatenate([np.zeros(before), motion, np.zeros(after)])
    position += np.random.default_rng(seed).normal(scale=noise, size=len(position)) if noise else 0.0
    return np.round(position / quantum) * quantum if quantum else position


@settings(max_examples=80, deadline=None)
@example(before=30, after=1570, frequency=0.995, noise=5e-3, quantum=1e-2, seed=2)  # noise of half a step
@given(
    st.integers(30, 2000), st.integers(30, 2000), st.floats(0.3, 10), st.sampled_from([0.0, 1e-3, 5e-3]),
    st.sampled_from([0.0, 1e-3, 1e-2]), st.integers(0, 5),
)  # fmt: skip
def test_the_ends_of_the_motion_are_found_to_a_twentieth_of_a_cycle(before, after, frequency, noise, quantum, seed):
    position = stroke(before, after, frequency, noise, quantum, seed)
    motion = find_motion(position)
    slack = 0.05 * RATE / frequency + 2
    assert abs(motion.start - before) <= slack
    assert abs(motion.stop - (len(position) - after)) <= slack
    assert rest_position(position, motion) == pytest.approx(30.0, abs=0.02)
    assert middle_position(position) == pytest.approx(30.0, abs=0.02)


def test_a_record_that_moves_from_end_to_end_is_kept_whole():
    motion = find_motion(stroke(0, 0, 1.0, 1e-3, 0.0))
    assert motion.start < 0.05 * RATE and motion.stop > 4.95 * RATE


def test_a_record_that_never_moves_is_kept_whole():
    still = np.random.default_rng(0).normal(scale=1e-3, size=2000)
    assert find_motion(np.full(2000, 3.0)) == find_motion(np.full(2000, 7.0))
    assert find_motion(np.full(2000, 3.0)).stop == 2000
    assert find_motion(still).stop - find_motion(still).start == 2000


def test_a_single_spike_at_rest_is_no_motion():
    position = stroke(1000, 0, 1.0, 1e-3, 0.0)
    position[300] += 5.0
    assert find_motion(position).start > 950


def test_missing_samples_do_not_move_the_ends():
    position = stroke(500, 500, 2.0, 1e-3, 0.0)
    position[100:120] = np.nan
    position[-50:] = np.nan
    motion = find_motion(position)
    assert 480 < motion.start < 520 and abs(motion.stop - (len(position) - 500)) < 20


def test_few_samples_are_all_motion():
    assert find_motion(np.array([1.0, 2.0, np.nan])).stop == 3
