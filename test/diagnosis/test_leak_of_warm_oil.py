"""Warm oil leaks more past the elements of a damper: only a thermometer tells it from a worn gap."""

from dataclasses import replace

import numpy as np
import pytest
from roads import road

import damper_estimator as de
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model.element import new_element

RATE, SECONDS = 500.0, 30.0
LEAK = 2e-5  # m/(s N) of piston velocity, at 20 deg C


def recording(name: str, seed: int, leak: float = LEAK, warm: tuple[float, float] | None = None) -> de.Recording:
    """A damper with a digressive valve and a laminar leak in parallel, on a road; the flows add up."""
    random, time = np.random.default_rng(seed), np.arange(round(RATE * SECONDS)) / RATE
    x = road(random, time, 10.0, size=4e-3, slope=1.8)
    v = np.gradient(x, time)
    forces = np.linspace(-6000.0, 6000.0, 24001)
    flow = 0.05 * np.sinh(forces / 700.0) + 4e-5 * forces
    force = np.interp(v, flow + leak * forces, forces)
    noise = 2.0 * random.standard_normal(v.size)
    temperature = None if warm is None else np.linspace(*warm, v.size) + 0.05 * random.standard_normal(v.size)
    return de.Recording.from_arrays(time, x, force=force + noise, temperature=temperature, name=name)


def found(leak: float, before: tuple[float, float] | None, after: tuple[float, float] | None, springs=()):
    """The diagnosis of a damper whose leak changed after its identification; its model has springs, stiff ones."""
    model = fitted = de.fit(recording("base", 1, warm=before), "viscous_curve").model
    for name, stiffness in springs:
        model = model.with_missing(new_element(find_effect(name), model.effects, stiffness))
    model = replace(model, fit=fitted.fit)
    fit, unseen = (recording(name, seed, leak, after) for name, seed in (("fit", 2), ("unseen", 3)))
    return de.diagnose(fit, model, validate=unseen).diagnosis


@pytest.mark.parametrize("after", [(50.0, 50.3), (48.0, 53.0)])
def test_a_leak_that_came_with_warm_oil_is_its_temperature(after):
    diagnosis = found(3.0 * LEAK, (20.0, 21.0), after)
    first = diagnosis.findings[0]
    assert first.phenomenon == "temperature_fade" and not first.tied_with
    assert first.rmse_after_n < 0.3 * first.rmse_before_n


def test_it_is_tried_behind_the_springs_of_a_model():
    oil = {"stiffness_rebound": 2e7, "stiffness_compression": 2e7}
    springs = (("oil_spring", oil), ("rubber_mount", {"stiffness": 3e7}))
    first = found(3.0 * LEAK, (20.0, 21.0), (50.0, 50.3), springs).findings[0]
    assert first.effect == "warm_leak" and first.rmse_after_n < 0.3 * first.rmse_before_n


@pytest.mark.parametrize("channel", [None, (20.0, 21.0)])
def test_a_leak_in_front_of_a_curve_is_another_curve_and_no_hysteresis(channel):
    diagnosis = found(3.0 * LEAK, channel, channel)
    named = {name for one in diagnosis.findings for name in (one.phenomenon, *one.tied_with)}
    assert named and "hysteresis" not in named
