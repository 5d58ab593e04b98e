"""Rest is found relative to the data's noise."""

import numpy as np
import pytest

from damper_estimator.signals.rest import find_rests, noise_level, quantum

RATE = 200
EDGE = 0.25  # s


def recording(parts, noise=1e-5, step=0.0, seed=0):
    """Stretches of (seconds, amplitude) at 1 Hz, with noise and quantisation; stamps and values."""
    draw = np.random.default_rng(seed)
    values = [0.003 + a * np.sin(2 * np.pi * np.arange(round(s * RATE)) / RATE) for s, a in parts]
    x = np.concatenate(values)
    x = x + noise * draw.standard_normal(x.size)
    return (np.arange(x.size) * 10**9) // RATE, np.round(x / step) * step if step else x


@pytest.mark.parametrize(("noise", "step"), [(1e-5, 0.0), (0.0, 0.0), (0.0, 1e-4), (3e-5, 1e-4), (2e-4, 0.0)])
def test_rest_is_found_where_it_is(noise, step):
    stamp, x = recording([(2.0, 0.0), (6.0, 0.02), (1.5, 0.0)], noise, step)
    rests = find_rests(stamp, x)
    assert [(r.start, r.end) for r in rests] == [
        (0.0, pytest.approx(2.0, abs=EDGE)),
        (pytest.approx(8.0, abs=EDGE), pytest.approx(9.5, abs=EDGE)),
    ]
    assert rests[0].displacement == pytest.approx(0.003, abs=2e-5 + step)


@pytest.mark.parametrize("frequency", [0.1, 1.0, 15.0])
def test_a_moving_damper_never_rests(frequency):
    time = np.arange(6000) / RATE
    x = 0.02 * np.sin(2 * np.pi * frequency * time) + 1e-5 * np.random.default_rng(0).standard_normal(6000)
    assert find_rests((time * 1e9).astype(np.int64), x) == ()


def test_a_varying_force_is_no_rest():
    stamp, still = recording([(10.0, 0.0)])
    _, force = recording([(3.0, 0.0), (7.0, 500.0)], noise=2.0)
    (rest,) = find_rests(stamp, still, stamp, force)
    assert (rest.start, rest.end) == (0.0, pytest.approx(3.0, abs=EDGE))


def test_less_than_half_a_second_is_no_rest():
    assert find_rests(*recording([(0.4, 0.0), (5.0, 0.02)])) == ()


def test_a_gap_in_the_recording_is_no_rest():
    stamp, x = recording([(4.0, 0.02)])
    stamp = np.where(np.arange(stamp.size) > 400, stamp + 3 * 10**9, stamp)
    assert find_rests(stamp, x) == ()


def test_empty_recordings_have_no_rest():
    assert find_rests(np.zeros(0, np.int64), np.zeros(0)) == ()


def test_noise_and_quantum_are_measured():
    values = np.random.default_rng(0).normal(size=20000)
    assert noise_level(values) == pytest.approx(1.0, rel=0.05) and quantum(values) == 0.0
    assert quantum(np.round(values / 0.2) * 0.2) == pytest.approx(0.2)


def test_real_tests_rest_between_their_blocks(shared_data):
    """The press rests between the five currents: pauses of seconds, at the same displacement to 0.05 mm."""
    import gzip

    lines = (
        gzip.open(shared_data / "utfsm_mr_damper" / "ME10mm2Hz.txt.gz", "rt", errors="replace").read().splitlines()[7:]
    )
    rows = np.array([[float(cell) for cell in line.split(",")[2:4]] for line in lines if line.count(",") >= 3])
    stamp = np.arange(len(rows)) * 1_000_000
    rests = find_rests(stamp, 0.01 * rows[:, 0], stamp, 980.665 * rows[:, 1])
    assert len(rests) == 6 and np.ptp([r.displacement for r in rests]) < 5e-5
