"""A constant displacement: a fault if its sensor is noisy, else a standing car."""

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, make_element
from damper_estimator.runtime import DEGRADED, STUCK, Line, deployed

STEP = 2_000_000  # ns
RESOLUTION = 1e-5  # m
FIT = {"residual_stddev": 10.0, "region": {"velocity": [-9.0, 9.0]}}
MODEL = DamperModel("m", "", (make_element(find_effect("linear_viscous")),), fit=FIT)


def driven(displacement):
    """Status of every sample, and how many were stuck."""
    line = Line()
    line.add("one", deployed(MODEL, 60.0, 0.1))
    status = []
    for i, value in enumerate(displacement):
        line.step(i * STEP, np.array([value]), np.ones(1, bool))
        status.append(int(line.output.status[0, 0]))
    return np.array(status), int(line.records["counts"][0, STUCK])


def road(size, seed, noise, resolution):
    """A drive of a wheel and body in m, as measured by a sensor."""
    random, time = np.random.default_rng(seed), 0.002 * np.arange(size)
    x = 0.008 * np.sin(8.0 * time + seed) + 0.003 * np.sin(47.0 * time) * np.sin(0.7 * time)
    return quantised(x, random, noise, resolution)


def quantised(x, random, noise, resolution):
    x = x + noise * random.standard_normal(x.size)
    return resolution * np.round(x / resolution) if resolution else x


@pytest.mark.parametrize("noise", [1.2e-5, 3e-5])
@pytest.mark.parametrize("seed", range(3))
def test_a_stuck_noisy_sensor_is_found_within_a_tenth_of_a_second(noise, seed):
    x = road(4000, seed, noise, RESOLUTION)
    x[2500:3000] = x[2500]
    status, count = driven(x)
    assert count > 400 and (status[2550:3000] == DEGRADED).all()
    assert driven(road(4000, seed, noise, RESOLUTION))[1] == 0


def test_it_is_also_found_soon_after_noise_jumps_and_a_standstill():
    x = road(6000, 4, 1.2e-5, RESOLUTION)
    x[1500:1800] += 2e-3 * np.random.default_rng(1).standard_normal(300)
    x[2000:2200] += 0.01
    for first in (2800, 3700, 4600):
        x[first : first + 250] = x[first]
    status, _ = driven(x)
    for first in (2800, 3700, 4600):
        assert (status[first + 50 : first + 250] == DEGRADED).all()


QUIET = [(noise, RESOLUTION) for noise in (0.0, 1e-6, 2e-6, 3.5e-6, 5e-6, 1.2e-5)] + [(0.0, 0.0), (1e-5, 0.0)]


@pytest.mark.parametrize("noise, resolution", QUIET)
@pytest.mark.parametrize("place", [0.0, 0.3, 0.5])
def test_a_car_that_stops_and_stands_raises_no_alarm(noise, resolution, place):
    driving = road(4000, 1, noise, resolution)
    time = 0.002 * np.arange(4000)
    rest = place * RESOLUTION + 1e-3 * np.exp(-8.0 * time) * np.cos(9.0 * time)
    standing = quantised(rest, np.random.default_rng(5), noise, resolution)
    assert driven(np.concatenate([driving, driving[-1] - standing[0] + standing, driving]))[1] == 0
