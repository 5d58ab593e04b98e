"""From recordings to diagrams: cycles, averages, quasi-static and setting subtraction, random motion."""

import json

import numpy as np
import pytest
from shapes import measurement_of, sine, sine_test

from damper_estimator.characterization import characterize, mean_loops, quasi_static
from damper_estimator.characterization.serialization import PEAK_COLUMNS, peaks, peaks_csv, record
from damper_estimator.errors import InputError
from damper_estimator.files import plain


def viscous(x, v, a):
    """A digressive damper."""
    return 800.0 * np.tanh(v / 0.1) + 500.0 * v


def gas(x):
    """A planted gas force, curved over the stroke."""
    return -250.0 - 4000.0 * x + 60000.0 * x**2


def current_part(current, v):
    """A planted semi-active part."""
    return 400.0 * current * np.tanh(v / 0.02)


def test_sine_tests_become_one_diagram_per_operating_point():
    tests = [sine_test(viscous, f, a) for f, a in ((1.0, 0.02), (4.0, 0.01), (10.0, 0.004))]
    found = characterize(tests)
    assert [round(d.loop.frequency, 2) for d in found.diagrams] == [1.0, 4.0, 10.0]
    assert [d.loop.amplitude for d in found.diagrams] == pytest.approx([0.02, 0.01, 0.004], rel=1e-3)
    assert all(d.loop.steady for d in found.diagrams)
    assert [band.passive is not None for band in found.bands] == [True, True, True]


def test_two_recordings_of_one_motion_are_one_diagram():
    found = characterize([sine_test(viscous, name="a.mcap"), sine_test(viscous, seed=1, noise=0.01, name="b.mcap")])
    assert len(found.diagrams) == 1
    assert found.diagrams[0].loop.recordings == ("a.mcap", "b.mcap")


def test_commands_are_separate():
    found = characterize([sine_test(viscous, command=c) for c in (0.0, 0.5, 1.0)])
    assert [d.loop.command for d in found.diagrams] == [0.0, 0.5, 1.0]


def test_the_mean_loop_is_the_law():
    loop = mean_loops([m := sine_test(viscous, noise=0.01)], [m.force])[0][0]
    law = viscous(loop.displacement, loop.velocity, loop.acceleration)
    assert np.sqrt(np.mean((loop.force - law) ** 2)) < 0.01 * np.abs(law).max()


def test_forces_are_reported_at_peak_speed_and_not_at_peak_force():
    stiff = sine_test(lambda x, v, a: 1000.0 * v + 20000.0 * x, 2.0, 0.02)
    row = peaks(characterize([stiff]).diagrams[0].loop)
    assert row["force_rebound_n"] == pytest.approx(1000.0 * row["peak_velocity_rebound_m_s"], rel=0.05)
    assert row["largest_force_n"] > 1.5 * row["force_rebound_n"]


def test_the_peaks_table_has_a_row_for_every_operating_point():
    diagrams = characterize([sine_test(viscous, f, a) for f, a in ((4.0, 0.01), (1.0, 0.02))]).diagrams
    head, *rows = peaks_csv(diagrams).splitlines()
    assert head.split(",") == list(PEAK_COLUMNS)
    velocities = [float(row.split(",")[5]) for row in rows]
    assert velocities == sorted(velocities) and len(rows) == 2


def slow_test(law, rate=200.0):
    """A sine of 5 mm/s over the whole stroke."""
    motion = sine(np.arange(round(60.0 * rate)) / rate, 0.04, 0.02)
    return measurement_of(motion, law(*motion), rate, name="slow.mcap")


def test_quasi_static_subtraction_removes_a_planted_gas_force():
    slow = quasi_static(slow_test(lambda x, v, a: gas(x)))
    damped = sine_test(lambda x, v, a: viscous(x, v, a) + gas(x), 3.0, 0.018)
    loop = characterize([damped], slow=slow).diagrams[0].loop
    rest = loop.force - viscous(loop.displacement, loop.velocity, loop.acceleration)
    assert np.abs(rest).max() < 0.02 * np.ptp(gas(loop.displacement)) + 5.0


def test_quasi_static_subtraction_removes_friction_by_direction():
    slow = quasi_static(slow_test(lambda x, v, a: gas(x) + 60.0 * np.sign(v)))
    remaining = slow.remaining(sine_test(lambda x, v, a: gas(x) + 60.0 * np.sign(v), 3.0, 0.018))
    assert np.sqrt(np.mean(remaining**2)) < 6.0


def test_a_slow_test_that_is_not_slow_is_refused():
    slow = quasi_static(sine_test(viscous, 1.0, 0.02))
    with pytest.raises(InputError, match="not slow"):
        characterize([sine_test(viscous, 2.0, 0.02)], slow=slow)


def test_a_slow_test_with_less_stroke_is_reported():
    slow = quasi_static(slow_test(lambda x, v, a: gas(x)))
    found = characterize([sine_test(viscous, 2.0, 0.03)], slow=slow)
    assert any("covers less stroke" in note for note in found.notes)


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_subtraction_of_commands_recovers_the_planted_semi_active_part(noise):
    tests = [
        sine_test(lambda x, v, a, c=c: viscous(x, v, a) + current_part(c, v), command=c, noise=noise, seed=int(c))
        for c in (0.0, 1.0, 2.0)
    ]
    found = characterize(tests)
    assert [d.loop.command for d in found.differences] == [1.0, 2.0]
    for diagram in found.differences:
        planted = current_part(diagram.loop.command, diagram.loop.velocity)
        assert np.sqrt(np.mean((diagram.loop.force - planted) ** 2)) < 0.005 * 800.0 + 2.0 * noise * 400.0
        assert diagram.pattern.type == 4
    assert found.bands[0].semi_active == 4
    assert found.structure.semi_active == "simple"


def test_a_second_recording_is_subtracted_at_the_same_motion_and_named_after_the_difference():
    low = sine_test(viscous, pressure=1e5)
    high = sine_test(lambda x, v, a: 1.2 * viscous(x, v, a), pressure=20e5)
    difference = characterize([high], [low]).differences[0]
    assert difference.role == "pressure"
    assert difference.subtrahend == pytest.approx(1e5)
    law = 0.2 * viscous(difference.loop.displacement, difference.loop.velocity, difference.loop.acceleration)
    assert np.abs(difference.loop.force - law).max() < 5.0


def test_another_motion_cannot_be_subtracted():
    with pytest.raises(InputError, match="no motion in common"):
        characterize([sine_test(viscous, 2.0)], [sine_test(viscous, 3.0)])


def random_motion(seconds, low, high, seed=3, rate=500.0):
    """Displacement, velocity, acceleration of band-limited noise."""
    rng = np.random.default_rng(seed)
    f = np.fft.rfftfreq(round(seconds * rate), 1.0 / rate)
    spectrum = np.where((f > low) & (f < high), rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size), 0.0)
    scale = 0.01 / np.fft.irfft(spectrum).std()
    w = 2j * np.pi * f
    return tuple(np.fft.irfft(scale * w**k * spectrum) for k in range(3)), rate


def test_a_random_recording_is_reported_as_no_sine_test():
    motion, rate = random_motion(60.0, 1.0, 2.0)
    found = characterize([measurement_of(motion, viscous(*motion), rate)])
    assert not any(d.loop.steady for d in found.diagrams)
    assert any("single cycles" in note for note in found.notes)
    assert found.bands[2].passive is None
    assert "no steady sine cycles" in found.bands[2].why


def test_a_recording_without_a_suitable_cycle_is_refused():
    motion, rate = random_motion(4.0, 0.1, 3.0)
    with pytest.raises(InputError, match="has no motion that characterizes"):
        characterize([measurement_of(motion, viscous(*motion), rate)])


def test_the_record_is_plain_json():
    found = characterize([sine_test(viscous, command=c) for c in (0.0, 1.0)])
    assert json.loads(json.dumps(plain(record(found)), allow_nan=False))["operating_points"][0]["type"] in range(7)
