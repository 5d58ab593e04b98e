"""Elasto-plastic elements, seals and rubber."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.plant.parts import Seal, Stops
from damper_estimator.plant.solids import ELEMENTS, drag_sliders, seal_strength, stack_share, stop_force

REACH = 1e-4


def walk(places: np.ndarray, sliders: np.ndarray | None = None) -> np.ndarray:
    """Shares along a path, committing every position."""
    sliders = np.zeros(ELEMENTS) if sliders is None else sliders
    shares = np.empty(places.size)
    for number, place in enumerate(places):
        shares[number] = stack_share(place, sliders, 0, REACH)
        drag_sliders(place, sliders, 0, REACH)
    return shares


def test_the_stack_is_elastic_at_first_and_slides_at_full_strength() -> None:
    shares = walk(np.linspace(0.0, 1e-3, 200))
    assert shares[0] == 0.0
    assert 0.0 < shares[2] < 0.3
    assert (np.diff(shares) >= 0.0).all()
    assert shares[-1] == pytest.approx(1.0)


def test_a_reversal_turns_the_force_over_twice_the_reach() -> None:
    shares = walk(np.concatenate((np.linspace(0.0, 1e-3, 200), np.linspace(1e-3, 0.0, 200))))
    assert shares[199] == pytest.approx(1.0)
    assert shares[-1] == pytest.approx(-1.0)


@given(st.lists(st.floats(-1e-3, 1e-3), min_size=2, max_size=30))
def test_the_force_depends_on_the_path_not_on_its_discretisation(corners: list[float]) -> None:
    path = np.array([0.0, *corners])
    fine = np.interp(np.arange(0.0, path.size - 1 + 1e-9, 0.125), np.arange(path.size), path)
    assert walk(path)[-1] == pytest.approx(walk(fine)[-1], abs=1e-9)


@given(st.lists(st.floats(-1e-3, 1e-3), min_size=2, max_size=20))
def test_a_closed_path_never_produces_energy(corners: list[float]) -> None:
    legs = len(corners) + 1
    path = np.interp(np.linspace(0, legs, 60 * legs), np.arange(legs + 1), [0.0, *corners, 0.0])
    twice = np.concatenate((path, path))
    shares = walk(twice)
    half = path.size
    work = np.sum(0.5 * (shares[half:-1] + shares[half + 1 :]) * np.diff(twice[half:]))
    assert work > -1e-9


def test_seals_grip_harder_under_pressure_and_before_they_slide() -> None:
    seal = Seal(force=10.0, per_pressure=1e-5, stiction=0.5)
    assert seal_strength(seal, 101325.0, 1.0) == pytest.approx(10.0, rel=1e-3)
    assert seal_strength(seal, 101325.0, 0.0) == pytest.approx(15.0)
    assert seal_strength(seal, 1101325.0, 1.0) == pytest.approx(20.0, rel=1e-3)


def test_stops_push_and_never_pull() -> None:
    stops = Stops(compression=-0.02, rebound=0.02, stiffness=1e4)
    assert stop_force(stops, 0.0, 1.0) == 0.0
    assert stop_force(stops, -0.03, 0.0) < stop_force(stops, -0.025, 0.0) < 0.0
    assert stop_force(stops, 0.03, 0.0) > stop_force(stops, 0.025, 0.0) > 0.0
    assert stop_force(stops, -0.03, 10.0) == 0.0
    assert stop_force(stops, -0.03, -1.0) < stop_force(stops, -0.03, 1.0)
