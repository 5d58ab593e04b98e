"""Corrects of the measurement chain: what would have been measured with the corrected map."""

from dataclasses import replace

import numpy as np
import pytest
from faults import BAGS, DAMPER

from damper_estimator.diagnosis.correction import corrected, corrected_signals
from damper_estimator.effects.discovery import all_effects
from damper_estimator.model import make_element
from damper_estimator.recordings import open_bag
from damper_estimator.signals import SignalMap, measure
from damper_estimator.signals.channels import signals_for

MISTAKES = {
    "channel_skew": {"skew": 0.004},
    "force_offset": {"offset": 35.0},
    "force_gain_error": {"gain": 0.1},
    "gain_drift": {"gain": 0.1},
    "spring_rate_error": {"rate": 3000.0},
}


def test_every_channel_effect_knows_its_correction():
    channel = {name for name, effect in all_effects().items() if effect.kind == "channel"}
    assert channel == set(MISTAKES)
    assert all(all_effects()[name].correct is not None for name in channel)


@pytest.mark.parametrize("name", MISTAKES)
def test_correcting_is_reading_with_the_corrected_map(name, base):
    element = make_element(all_effects()[name], MISTAKES[name])
    bag = open_bag(BAGS / "hidden_base.mcap")
    signals = corrected_signals(base.signals, element)
    given = replace(signals_for(bag, SignalMap(), DAMPER), dampers={DAMPER: signals})
    anew, turned = measure(bag, given, DAMPER), corrected(base, signals)
    both = anew.judged & turned.judged
    scale = np.std(base.force[both])
    # A skew moves the filter's start: apart from that only interpolation between samples differs.
    assert np.abs(anew.in_band(anew.force) - turned.in_band(turned.force))[both].max() < 0.02 * scale


@pytest.mark.parametrize("spring", [{}, {"spring_rate": 30e3, "preload": -1500.0}], ids=["alone", "coil over"])
@pytest.mark.parametrize("name", MISTAKES)
def test_a_correction_takes_back_what_the_effect_does(name, spring, base, user_model):
    """The effect says how the mistake shows in the force, a spring in the gauge's force included; the correction must
    undo just that.
    """
    effect = all_effects()[name]
    base = replace(base, signals=replace(base.signals, **spring))
    settings = {setting.name: spring.get(setting.name, setting.default) for setting in effect.settings}
    element = make_element(effect, MISTAKES[name] | settings)
    block = base.kinematics.block
    right = replace(base, force=user_model.force(block))
    wrong = replace(base, force=user_model.with_effect(element).force(block))
    again = corrected(wrong, corrected_signals(base.signals, element))
    judged = base.judged.copy()
    judged[-50:] = False  # a lead cannot look beyond the end
    error = (again.in_band(again.force) - right.in_band(right.force))[judged]
    assert np.std(error) < 2e-3 * np.std(right.force[judged])
