"""The noise floor: what a perfect model would still show, whatever sensors measured it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from damper_estimator.plant import simulate
from damper_estimator.signals import low_pass
from damper_estimator.signals.layout import X
from damper_estimator.validation import compare
from damper_estimator.validation.noise import noise_density, noise_floor

SILENT = {"displacement_noise": 0.0, "displacement_step": 0.0, "force_noise": 0.0, "force_step": 0.0}
STEADY = {"force_drift": 0.0, "drop_out": 0.0}
SENSORS = {
    "ordinary": {},
    "quiet displacement": {"displacement_noise": 2e-6, "displacement_step": 1e-6},
    "loud displacement": {"displacement_noise": 1e-4},
    "coarse displacement": {"displacement_step": 1e-4},
    "very coarse displacement": {"displacement_step": 5e-4},
    "quiet gauge": {"force_noise": 0.5, "force_step": 0.0},
    "loud gauge": {"force_noise": 40.0},
    "coarse gauge": {"force_step": 50.0},
    "100 Hz": {"rate": 100.0},
    "200 Hz": {"rate": 200.0},
    "2 kHz": {"rate": 2000.0},
    "100 Hz, loud": {"rate": 100.0, "displacement_noise": 1e-4, "force_noise": 20.0},
    "uneven": {"clock_jitter": 3e-4},
}
TIME = np.arange(20000) / 500.0


def perfect_models_error(truth, noisy, clean):
    """RMS in N of the difference that the sensors' errors alone make, in the gauge and in the force of the only perfect
    model, which is the simulated damper itself.
    """
    time = 1e-9 * noisy.kinematics.stamp
    error = CubicSpline(time, noisy.kinematics.block[X] - clean.kinematics.block[X])
    inside = np.clip(truth.drive.time, time[0], time[-1])
    shaken = replace(truth.drive, displacement=truth.drive.displacement + error(inside))
    change = np.interp(time, truth.drive.time, simulate(truth.damper, shaken).force - truth.force)
    whole = noisy.in_band(change - noisy.as_gauge(noisy.gauge - clean.gauge))
    return float(np.sqrt(np.mean(whole[noisy.judged] ** 2)))


def fewer(every):
    """A gauge with a different rate."""

    def change(channels):
        force = channels["force"]
        fields = (force.log, force.stamp, force.value)
        return channels | {"force": type(force)(*(values[::every] for values in fields))}

    return change


@pytest.fixture(scope="module")
def ratio(recorded, truth_of):
    """The floor over the error of the perfect model."""

    def of(damper="passenger_front", excitation="random", change=None, **sensors):
        pair = [recorded(damper, excitation, change=change, **(STEADY | sensors | more)) for more in ({}, SILENT)]
        return noise_floor(pair[0]) / perfect_models_error(truth_of(damper, excitation, 1), *pair)

    return of


DRIVES = [("passenger_front", "random"), ("passenger_front", "road"), ("light_car", "road")]


def test_the_floor_is_the_error_of_the_perfect_model(ratio):
    found = {(drive, name): ratio(*drive, **sensors) for drive in DRIVES for name, sensors in SENSORS.items()}
    near = [value for value in found.values() if 0.75 <= value <= 1.3]
    assert len(near) >= 0.8 * len(found), found
    assert all(0.6 <= value <= 1.35 for value in found.values()), found


@pytest.mark.parametrize("sensors", ["ordinary", "quiet displacement", "loud displacement", "coarse displacement"])
def test_a_moving_current_changes_what_noise_does(sensors, ratio):
    assert 0.5 <= ratio("semi_active", "road", **SENSORS[sensors]) <= 1.35


@pytest.mark.parametrize("sensors", [SENSORS["ordinary"], SENSORS["loud displacement"]])
def test_with_sines_and_heavy_friction_it_is_rather_too_low_than_too_high(sensors, ratio):
    assert 0.5 <= ratio("rally_rear", "dyno", **sensors) <= 1.2


@pytest.mark.parametrize("every", [3, 5])
def test_a_gauge_may_have_another_rate(every, ratio):
    assert 0.75 <= ratio(change=fewer(every)) <= 1.25


def test_of_a_made_recording_it_is_the_error_that_compare_shows(viscous, motion, measured):
    """Gauge and displacement noise are put on; the model is the true one; its error is what the floor foretells."""
    time, x = motion(60.0)
    draw = np.random.default_rng(1)
    noisy, gauge_noise = x + 2e-5 * draw.standard_normal(x.size), 20.0 * draw.standard_normal(x.size)
    clean = {}
    measured(time, x, lambda k: clean.setdefault("force", 1500.0 * k.velocity))
    m = measured(
        time, noisy, lambda k: clean["force"] + low_pass(60.0, k.dt, gauge_noise), gauge=clean["force"] + gauge_noise
    )
    c = compare(viscous, m)
    assert c.noise_floor_n == pytest.approx(c.measures.rmse_n, rel=0.15)
    assert c.regions == ()


@settings(deadline=None, max_examples=12)
@given(seed=st.integers(0, 10**6), damping=st.floats(1e3, 2e4), delay=st.floats(0.0, 0.01), size=st.floats(3e-6, 5e-5))
def test_a_spring_in_series_keeps_fast_noise_from_the_damper(motion, measured, seed, damping, delay, size):
    """Whatever the stiffness (damping over delay): the perfect model of a damper behind a spring shows the floor."""
    time, x = motion(40.0, seed=seed)
    keep = np.exp(-2e-3 / delay) if delay > 1e-6 else 0.0

    def force_of(travel):  # exact for displacements that are linear between samples
        return lfilter([damping * (1.0 - keep)], [1.0, -keep], np.diff(travel, prepend=travel[0]) * 500.0)

    noisy = x + size * np.random.default_rng(seed).standard_normal(x.size)
    clean = force_of(x)
    m = measured(time, noisy, lambda k: low_pass(60.0, k.dt, clean), gauge=clean)
    error = m.in_band(force_of(m.kinematics.displacement) - force_of(low_pass(60.0, m.kinematics.dt, x)))
    assert noise_floor(m) == pytest.approx(float(np.sqrt(np.mean(error[m.judged] ** 2))), rel=0.2)


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 10**6), size=st.floats(1e-3, 1e3), jitter=st.floats(0.0, 0.3), lost=st.floats(0.0, 0.02))
def test_the_density_of_noise_depends_on_nothing_else(seed, size, jitter, lost):
    """Motion, uneven stamps and lost samples leave it; it goes with the square of the noise."""
    draw, even = np.random.default_rng(seed), np.arange(3 * TIME.size) * 2e-3  # long, so that chance is no error
    time = (even + jitter * 2e-3 * draw.uniform(-1.0, 1.0, even.size))[draw.random(even.size) >= lost]
    smooth = 300.0 * size * np.sin(2 * np.pi * 3.0 * time) + 30.0 * size * np.sin(2 * np.pi * 15.0 * time)
    value = smooth + size * draw.standard_normal(time.size)
    density = noise_density(np.round(time * 1e9).astype(np.int64), value)
    assert np.sqrt(density * 250.0) == pytest.approx(size, rel=0.12)


def test_no_floor_is_reported_for_a_few_samples(viscous, motion, measured):
    assert np.isnan(compare(viscous, measured(*motion(1.0, rate=80.0), lambda k: 900.0 * k.velocity)).noise_floor_n)
