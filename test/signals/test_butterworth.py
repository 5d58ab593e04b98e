"""The filter: exact for input that is linear between samples, on even and uneven steps, sample by sample or in
blocks.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from damper_estimator.compiled import plain
from damper_estimator.signals.butterworth import (
    STATE_SIZE,
    delay_seconds,
    differentiate,
    low_pass,
    low_pass_zero_phase,
)

EXACT = 1e-9  # of the signal's scale: rounding of the exponentials and of lsim's matrix exponential
CUTOFF = 60.0


def steps(stamp_s):
    return np.diff(stamp_s, prepend=stamp_s[0])


def filtered(cutoff, stamp_s, raw, function=differentiate):
    x, v, a = np.empty((3, raw.size))
    function(cutoff, steps(stamp_s), raw, np.zeros(STATE_SIZE), x, v, a)
    return x, v, a


def reference(cutoff, time, raw, extra_poles=0):
    """scipy's response of the analogue filter and of its derivatives, from rest at the first value."""
    b, a = signal.butter(3, 2 * np.pi * cutoff, analog=True)
    outputs = []
    for order in range(3):
        numerator = np.concatenate([b[-1:], np.zeros(order)])
        _, y, _ = signal.lsim((numerator, a), raw - raw[0], time, interp=True)
        outputs.append(y + (raw[0] if order == 0 else 0.0))
    return outputs


@pytest.mark.parametrize("cutoff", [5.0, 20.0, 60.0, 150.0])
@pytest.mark.parametrize("rate", [100.0, 500.0, 1000.0])
def test_equals_lsim_on_even_steps(cutoff, rate):
    random = np.random.default_rng(1)
    time = np.arange(400) / rate
    raw = 0.02 + np.cumsum(random.normal(size=time.size)) * 1e-3
    w = 2 * np.pi * cutoff
    for order, (actual, theirs) in enumerate(
        zip(filtered(cutoff, time, raw), reference(cutoff, time, raw), strict=True)
    ):
        assert np.abs(actual - theirs).max() < 1e-7 * w**order * np.ptp(raw)


@given(seed=st.integers(0, 10_000), cutoff=st.floats(2.0, 200.0))
@settings(max_examples=25, deadline=None)
def test_equals_lsim_on_jittered_steps(seed, cutoff):
    """Uneven stamps are a subset of a fine even grid on which lsim has the same linear input."""
    random = np.random.default_rng(seed)
    fine = np.arange(3000) * 1e-4
    kept = np.unique(np.concatenate([[0], np.sort(random.choice(np.arange(1, 3000), 200, replace=False))]))
    raw = np.cumsum(random.normal(size=kept.size)) * 1e-3
    theirs = reference(cutoff, fine, np.interp(fine, fine[kept], raw))
    inside = fine[kept] <= fine[kept][-1]
    w = 2 * np.pi * cutoff
    for order, (actual, other) in enumerate(zip(filtered(cutoff, fine[kept], raw), theirs, strict=True)):
        assert np.abs(actual - other[kept])[inside].max() < 1e-6 * w**order * (np.ptp(raw) + 1e-6)


@pytest.mark.parametrize("frequency", [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0])
@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_sines_from_half_to_thirty_hertz_follow_the_transfer_function(frequency, jitter):
    """Steady state at 2 kHz; the tolerance is the error of a sine drawn as straight lines, (w dt)^2 / 8, thrice."""
    random = np.random.default_rng(3)
    step = 0.5e-3
    time = np.arange(0.0, 0.5 + 3.0 / frequency, step)
    time = time + jitter * step * random.uniform(-1.0, 1.0, time.size)
    time -= time[0]
    omega, w = 2 * np.pi * frequency, 2 * np.pi * CUTOFF
    s = 1j * omega
    gain = w**3 / (s**3 + 2 * w * s**2 + 2 * w**2 * s + w**3)
    outputs = filtered(CUTOFF, time, np.sin(omega * time))
    settled = time > 0.3
    # The corners of the straight lines enter the derivatives with their higher frequencies.
    chord = (omega * step * (1 + jitter)) ** 2 / 8
    for order, actual in enumerate(outputs):
        expected = np.imag(gain * s**order * np.exp(s * time))
        error = np.abs(actual - expected)[settled].max() / omega**order
        assert error < 3 * chord * max(1.0, w / omega) ** order + 1e-9


def test_derivatives_are_those_of_the_filtered_displacement():
    time = np.arange(4000) * 1e-4
    x, v, a = filtered(40.0, time, 0.01 * np.sin(2 * np.pi * 7 * time))
    middle = slice(1000, -1)
    assert np.gradient(x, time)[middle] == pytest.approx(v[middle], abs=1e-5 * np.abs(v).max() + 1e-4)
    assert np.gradient(v, time)[middle] == pytest.approx(a[middle], rel=0, abs=2e-3 * np.abs(a).max())


def test_a_ramp_is_followed_at_the_stated_delay_with_its_exact_slope():
    time = np.linspace(0.0, 1.0, 200)
    x, v, a = filtered(CUTOFF, time, 3.0 * time)
    assert v[-1] == pytest.approx(3.0, rel=1e-9)
    assert a[-1] == pytest.approx(0.0, abs=1e-6)
    assert x[-1] == pytest.approx(3.0 * (1.0 - delay_seconds(CUTOFF)), rel=1e-9)


@given(st.lists(st.integers(1, 60), min_size=1, max_size=30), st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_any_split_into_blocks_gives_the_same_bits(splits, seed):
    random = np.random.default_rng(seed)
    size = sum(splits)
    dt = random.choice([0.002, 0.0021, 0.01, 0.0], size)
    raw = random.normal(size=size)
    whole = np.empty((3, size))
    differentiate(CUTOFF, dt, raw, np.zeros(STATE_SIZE), *whole)
    state, parts, first = np.zeros(STATE_SIZE), [], 0
    for length in splits:
        part = np.empty((3, length))
        differentiate(CUTOFF, dt[first : first + length], raw[first : first + length], state, *part)
        parts.append(part)
        first += length
    assert np.array_equal(whole, np.concatenate(parts, axis=1))


def test_compiled_equals_plain_python():
    random = np.random.default_rng(0)
    time = np.cumsum(random.uniform(1e-4, 5e-3, 300))
    raw = random.normal(size=300)
    for actual, other in zip(
        filtered(CUTOFF, time, raw), filtered(CUTOFF, time, raw, plain(differentiate)), strict=True
    ):
        assert actual == pytest.approx(other, rel=1e-12, abs=1e-12 * np.abs(other).max())


def test_unfiltered_mode_yields_the_backward_difference_and_no_acceleration():
    time = np.array([0.0, 0.01, 0.03, 0.04])
    raw = np.array([1.0, 1.5, 1.1, 1.1])
    x, v, a = filtered(0.0, time, raw)
    assert np.array_equal(x, raw)
    assert v == pytest.approx([0.0, 50.0, -20.0, 0.0])
    assert not a.any()


def test_a_restart_forgets_what_was_before():
    dt = np.array([0.0, 0.01, 0.01, 0.0, 0.01])
    raw = np.array([5.0, 6.0, 7.0, 1.0, 1.0])
    x, v, a = np.empty((3, 5))
    differentiate(CUTOFF, dt, raw, np.zeros(STATE_SIZE), x, v, a)
    assert x[3:] == pytest.approx([1.0, 1.0]) and not v[3:].any() and not a[3:].any()


def test_zero_phase_has_no_delay_and_the_squared_gain():
    time = np.arange(5000) / 500.0
    raw = np.sin(2 * np.pi * 20.0 * time)
    out = low_pass_zero_phase(30.0, steps(time), raw)
    gain = 1.0 / (1.0 + (20.0 / 30.0) ** 6)
    middle = slice(1000, 4000)
    chord = (2 * np.pi * 20.0 / 500.0) ** 2 / 12
    assert out[middle] == pytest.approx(gain * raw[middle], abs=2 * chord)


def test_zero_phase_is_the_same_forward_and_backward_in_time():
    random = np.random.default_rng(5)
    time = np.cumsum(random.uniform(0.001, 0.003, 2000))
    raw = np.convolve(random.normal(size=2000), np.ones(50) / 50, "same")
    forward = low_pass_zero_phase(30.0, steps(time), raw)
    backward = low_pass_zero_phase(30.0, steps(-time[::-1]), raw[::-1])[::-1]
    inner = slice(200, -200)
    assert forward[inner] == pytest.approx(backward[inner], abs=0.02 * np.ptp(forward))


def test_low_pass_of_a_constant_is_the_constant():
    assert low_pass(30.0, np.full(50, 0.01), np.full(50, -7.0)) == pytest.approx(np.full(50, -7.0))


@given(st.integers(1, 9), st.integers(0, 5), st.integers(0, 2**32 - 1))
def test_columns_are_filtered_as_each_alone_bit_for_bit(count, restarts, seed):
    rng = np.random.default_rng(seed)
    dt = rng.uniform(1e-3, 3e-3, 400)
    dt[[0, *rng.integers(1, 400, restarts)]] = 0.0
    columns = rng.standard_normal((400, count))
    together = low_pass_zero_phase(30.0, dt, columns)
    each = np.stack([low_pass_zero_phase(30.0, dt, column) for column in columns.T], axis=1)
    assert np.array_equal(together, each)
    assert np.array_equal(low_pass_zero_phase(0.0, dt, columns), columns)
