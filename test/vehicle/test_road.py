"""Roads have the spectrum of their ISO 8608 class."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import welch

from damper_estimator.vehicle import CLASSES, bump_height, profile_spectrum, road_height

SPEED, STEP = 20.0, 2e-3


@pytest.mark.parametrize("road_class", CLASSES)
def test_the_profile_has_the_psd_of_its_class(road_class: str) -> None:
    height = road_height(road_class, SPEED, 500_000, STEP, seed=1)
    sampling = 1.0 / (STEP * SPEED)
    frequency, density = welch(height, sampling, nperseg=16384)
    bands = np.geomspace(0.02, 2.5, 13)  # 1/m
    for low, high in pairwise(bands):
        inside = (frequency >= low) & (frequency < high)
        ratio = np.mean(density[inside] / profile_spectrum(frequency[inside], road_class))
        assert ratio == pytest.approx(1.0, abs=0.2)


def test_the_classes_are_those_of_the_standard() -> None:
    values = [profile_spectrum(np.array([0.1]), letter)[0] for letter in "ABCDE"]
    assert values == pytest.approx([16e-6, 64e-6, 256e-6, 1024e-6, 4096e-6])


def test_a_seed_repeats_its_road_at_every_step_and_another_seed_differs() -> None:
    coarse = road_height("C", SPEED, 4000, 4e-3, seed=1)
    fine = road_height("C", SPEED, 16000, 1e-3, seed=1)
    other = road_height("C", SPEED, 4000, 4e-3, seed=2)
    assert coarse == pytest.approx(fine[::4], abs=1e-9)
    assert abs(np.corrcoef(coarse, other)[0, 1]) < 0.7
    assert coarse.mean() == pytest.approx(0.0, abs=1e-9)


def test_a_road_shorter_than_every_wave_is_refused() -> None:
    with pytest.raises(ValueError, match="too short"):
        road_height("C", 0.01, 10, 1e-3, seed=1)


def test_a_bump_has_the_stated_height_and_length() -> None:
    time = np.arange(0.0, 1.0, 1e-4)
    height = bump_height(0.05, 1.0, 10.0, time, 0.3)
    assert height.max() == pytest.approx(0.05)
    assert time[np.flatnonzero(height > 1e-9)[[0, -1]]] == pytest.approx([0.3, 0.4], abs=1e-3)
