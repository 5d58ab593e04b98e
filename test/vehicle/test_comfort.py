"""The comfort simulation: single curves, and their differences to models with memory."""

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, load_model, make_element
from damper_estimator.vehicle import load_car, single_curve
from damper_estimator.vehicle.comfort import AXLES, comfort_run, differences
from damper_estimator.vehicle.single_curve import FREQUENCY, SPEEDS, _sine

CAR = load_car("compact_car")


def test_the_single_curve_of_a_curve_is_itself():
    model = load_model("linear_viscous")
    for frequency, amplitude in ((0.7, 0.03), (8.0, 0.002)):
        block = _sine(amplitude, frequency)
        force = model.force(block)
        assert single_curve(model).force(block) == pytest.approx(force, abs=1e-3 * np.abs(force).max())


def test_a_single_curve_goes_through_the_peaks_of_the_sines_and_has_no_memory():
    model = DamperModel(
        "remembers", "test",
        (make_element(find_effect("viscous"), {"rate": 900.0}), make_element(find_effect("bouc_wen"))),
    )  # fmt: skip
    curve = single_curve(model)
    assert not curve.program.states
    for speed in SPEEDS[::4]:
        block = _sine(speed / (2.0 * np.pi * FREQUENCY), FREQUENCY)
        last = block[:, -2000:]
        forces = model.force(block)[-2000:]
        for place in (np.argmax(last[3]), np.argmin(last[3])):
            assert curve.force(last)[place] == pytest.approx(forces[place], abs=1e-6 * np.abs(forces).max() + 1e-9)


def test_friction_shows_at_small_excitation_and_less_and_less_at_large():
    model = DamperModel(
        "rubs", "test",
        (
            make_element(find_effect("viscous"), {"rate": 1500.0}),
            make_element(find_effect("dahl"), {"force": 40.0}),
        ),
    )  # fmt: skip
    curve = single_curve(model)
    amplitudes = (0.0005, 0.005, 0.03)
    runs, others = (
        [comfort_run(CAR, dict.fromkeys(AXLES, tested), a, seconds=12.0) for a in amplitudes]
        for tested in (model, curve)
    )
    for rms in differences(runs, others).values():
        assert rms[0] > 2.0 * rms[1] > 4.0 * rms[2]
        assert rms[2] < 0.1
    assert differences(runs, runs) == {axle: [0.0] * 3 for axle in AXLES}
