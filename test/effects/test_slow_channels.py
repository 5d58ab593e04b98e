"""What a command or a temperature says that stands still, or nearly, but not where the model was identified."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import entry, force, sweep

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.slow_channels import (
    changing_command,
    changing_temperature,
    command_moved,
    commands,
    moved_command,
    reference_commands,
    temperature_moved,
    temperatures,
)
from damper_estimator.effects.trial import Ranges, Untestable
from damper_estimator.signals.layout import DT, V, X

BY_TEMPERATURE = ("temperature_gain", "temperature_surface", "viscosity_gain", "warm_leak")
AMPERES = st.floats(0.0, 3.0)


def ranges(**channels) -> Ranges:
    """Of a motion, with channels."""
    return Ranges(-0.02, 0.02, 0.3, 20.0, 400.0, 20.0, **channels)


@given(here=AMPERES, there=AMPERES)
def test_a_constant_command_moved_if_it_is_not_where_the_model_was_identified(here, there):
    known = ranges(command=(here, here), model_command=(there, there))
    is_apart = abs(here - there) > max(0.05 * max(here, there), 0.02)
    assert command_moved(known) == is_apart
    with pytest.raises(Untestable):
        changing_command(known)
    if is_apart:
        assert moved_command(known) == commands(known) == (min(here, there), max(here, there))
        assert reference_commands(known) == (pytest.approx(there),)
    else:
        assert commands(known) == (here, here)
        with pytest.raises(Untestable):
            moved_command(known)


def test_a_command_that_changes_has_not_moved():
    assert not command_moved(ranges(command=(0.0, 1.0), model_command=(2.0, 2.0)))
    assert not command_moved(ranges(command=(0.5, 0.5), model_command=(0.0, 1.0))), "the model was identified there too"
    assert not command_moved(ranges(command=(0.5, 0.5))), "nothing is known of the identification"
    assert not command_moved(ranges(model_command=(0.5, 0.5)))


def test_a_temperature_moves_by_kelvins():
    for here, moved in ((20.0, False), (28.0, False), (60.0, True), (-20.0, True)):
        known = ranges(temperature=(here, here + 0.5), model_temperature=(22.0, 26.0))
        assert temperature_moved(known) == moved
        if moved:
            assert changing_temperature(known) == temperatures(known) == (min(here, 22.0), max(here + 0.5, 26.0))
        else:
            with pytest.raises(Untestable):
                changing_temperature(known)


def test_a_temperature_that_rises_less_than_it_differs_has_moved():
    known = ranges(temperature=(66.0, 69.0), model_temperature=(21.0, 25.0))
    assert temperature_moved(known) and temperatures(known) == (21.0, 69.0)
    assert not temperature_moved(ranges(temperature=(30.0, 60.0), model_temperature=(21.0, 25.0))), "it shows by itself"
    assert not temperature_moved(ranges(temperature=(24.0, 40.0), model_temperature=(21.0, 25.0))), "it was there too"


@pytest.mark.parametrize("name", ["command_gain", "command_slip", "command_surface", "command_yield"])
def test_effects_of_a_moved_command_are_tried_before_others_that_explain_as_much(name):
    tried = find_effect(name).trial(ranges(command=(1.0, 1.0), model_command=(0.25, 0.25)))
    assert tried.prior > 1.0 and tried.values["reference"] == 0.25 and not tried.conditions
    assert "1 A here" in tried.because and "0.25 A when" in tried.because
    changing = find_effect(name).trial(ranges(command=(0.0, 1.0), model_command=(0.25, 0.25)))
    assert changing.prior == 1.0 and not changing.because


@pytest.mark.parametrize("name", BY_TEMPERATURE)
def test_effects_of_a_moved_temperature_hold_where_the_model_was_identified(name):
    tried = find_effect(name).trial(ranges(temperature=(60.0, 60.4), model_temperature=(20.0, 24.0)))
    assert tried.prior > 1.0 and tried.values["reference"] == 22.0 and not tried.conditions
    assert "60 to 60.4 deg C here" in tried.because


@pytest.mark.parametrize("name", BY_TEMPERATURE)
def test_the_more_the_temperature_differs_the_more_probable_is_its_effect(name):
    priors = [
        find_effect(name).trial(ranges(temperature=(warm, warm + 1.0), model_temperature=(20.0, 22.0))).prior
        for warm in (28.0, 42.0, 72.0)
    ]
    assert 1.0 < priors[0] < priors[1] < priors[2]


@pytest.mark.parametrize("side", [1.0, -1.0])
@given(growth=st.floats(1e-6, 1e-5), warmer=st.floats(-30.0, 60.0), speed=st.floats(0.01, 0.5))
def test_a_warm_leak_is_a_dashpot_in_front_of_the_damper_that_its_temperature_sets(side, growth, warmer, speed):
    block = sweep(temperature=40.0 + warmer)
    block[V] = side * speed
    block[X] = np.cumsum(block[V] * block[DT])
    path = (entry("linear_viscous", rebound=2000.0, compression=1500.0),)
    slope = 2000.0 if side > 0.0 else 1500.0
    found = force(block, entry("warm_leak", growth=growth, reference=40.0, path=path))
    expected = side * speed / (1.0 / slope + max(growth * warmer, 0.0))
    assert found[-1] == pytest.approx(expected, rel=1e-4)


def test_a_leak_is_looked_for_only_where_the_oil_is_warmer():
    colder = ranges(temperature=(5.0, 6.0), model_temperature=(20.0, 24.0))
    with pytest.raises(Untestable, match="not warmer"):
        find_effect("warm_leak").trial(colder)


@pytest.mark.parametrize("name", ["command_slip", "command_yield"])
@given(amperes=AMPERES, reference=AMPERES)
def test_a_yield_force_counts_from_the_command_at_which_nothing_is_added(name, amperes, reference):
    def at(command: float, start: float) -> np.ndarray:
        return force(sweep(command=command), entry(name, saturation=0.7, reference=start))

    assert at(amperes, reference) == pytest.approx(at(amperes, 0.0) - at(reference, 0.0), abs=1e-9)
    assert np.abs(at(reference, reference)).max() < 1e-9


def test_a_damper_that_kept_its_temperature_did_not_warm_itself_up():
    """Whatever falls with time then is not the heat that the damper dissipates."""
    trial = find_effect("dissipation_fade").trial
    with pytest.raises(Untestable, match="thermometer shows"):
        trial(ranges(temperature=(30.0, 31.5)))
    with pytest.raises(Untestable, match="thermometer shows"):
        trial(ranges(temperature=(60.0, 60.5), model_temperature=(20.0, 22.0)))
    assert trial(ranges()).limits and trial(ranges(temperature=(30.0, 36.0))).limits
