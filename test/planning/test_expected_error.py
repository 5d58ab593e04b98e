"""What is expected of a new motion: right on average where it was measured, and loud where the motion is."""

import numpy as np
import pytest

from damper_estimator.numerics import spectrum_of
from damper_estimator.planning.expected_error import Errors, _over_force, _over_frequency

RATE = 200.0


@pytest.fixture
def rng():
    return np.random.default_rng(4)


@pytest.mark.parametrize(("constant", "share"), [(25.0, 0.0), (0.0, 0.02), (9.0, 0.01)])
def test_the_expected_error_is_right_on_average_over_the_recording(rng, constant, share):
    """However the error depends on the force: squares scatter by more than their mean."""
    force = 100.0 * rng.standard_normal(6000)
    squared = (constant + share * force**2) * rng.standard_normal(6000) ** 2
    found = _over_force(force, squared)
    assert found[0] + found[1] * np.mean(force**2) == pytest.approx(squared.mean(), rel=0.05)


def test_an_error_that_grows_with_the_force_is_found_to_grow(rng):
    force = 100.0 * rng.standard_normal(20000)
    constant, share = _over_force(force, 0.02 * force**2 * rng.standard_normal(20000) ** 2)
    assert share == pytest.approx(0.02, rel=0.15) and constant < 0.1 * share * np.mean(force**2)


def test_half_of_the_error_lies_where_a_step_drives_the_force(rng):
    errors = Errors(1.0, 1.0, 0.0, 1.0, 1e4, spectrum_of([rng.standard_normal(4000)], [RATE]))
    time = np.arange(1200) / RATE
    found = errors.spectrum_on(100.0 * np.sin(2.0 * np.pi * 10.0 * time), RATE)
    near = np.abs(found.frequency - 10.0) < 2.0
    share = found.density[near].sum() / found.density.sum()
    assert share == pytest.approx(0.5, abs=0.08)
    still = errors.spectrum_on(np.full(1200, 30.0), RATE)
    assert still is errors.spectrum


def test_a_delay_that_a_road_hardly_shows_is_expected_on_a_fast_sine(rng):
    """The squared error of a delay is (2 pi f delay)^2 of the squared force."""
    delay, count = 0.002, 24000
    frequency = np.fft.rfftfreq(count, 1.0 / RATE)
    low = np.exp(2j * np.pi * rng.random(frequency.size)) / (1.0 + (frequency / 3.0) ** 3)
    force = np.fft.irfft(low, count)
    force *= 300.0 / force.std()
    error = delay * np.gradient(force, 1.0 / RATE)
    usual = float(np.mean(error**2) / np.mean(force**2))
    spectra = spectrum_of([error], [RATE]), spectrum_of([force], [RATE])
    shares = _over_frequency(*spectra, float(np.mean(error**2)), float(np.mean(force**2)), 0.0)
    errors = Errors(0.0, 0.0, usual, 1.0, float(np.mean(force**2)), spectra[0], shares=shares)
    assert errors.by_frequency(force[None], RATE)[0] == pytest.approx(np.mean(error**2), rel=0.2)
    time = np.arange(1200) / RATE
    for fast in (8.0, 16.0, 25.0):
        sine = 40.0 * np.sin(2.0 * np.pi * fast * time)
        true = (2.0 * np.pi * fast * delay) ** 2 * np.mean(sine**2)
        assert errors.by_frequency(sine[None], RATE)[0] == pytest.approx(true, rel=0.5)
        assert true > 3.0 * usual * np.mean(sine**2)  # the error of the road as a whole would promise far less


def test_white_noise_is_no_error_of_the_form(rng):
    force = np.cumsum(rng.standard_normal(12000))
    noise = rng.standard_normal(12000)
    spectra = spectrum_of([noise], [RATE]), spectrum_of([force - force.mean()], [RATE])
    _, shares = _over_frequency(*spectra, 1.0, float(force.var()), 1.5)
    assert not shares.any()
