"""Two effects at once: those that cancel where the curve is straight, and those that a third one resembles."""

from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
from faults import changed, erring, halves, late, wandering
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.diagnosis import diagnose
from damper_estimator.diagnosis.diagnosis_data import slope_of

pairs = import_module("damper_estimator.diagnosis.pairs")


@pytest.mark.parametrize(("delay", "share"), [(0.003, 1.0), (0.002, 1.3), (0.005, 1.0), (0.006, 1.1)])
def test_both_of_two_that_act_against_each_other_are_found(user_model, base, delay, share):
    a = base.kinematics.acceleration
    slope = slope_of(user_model, base.kinematics.block)
    mass = share * delay * float(np.sum(slope * a**2) / np.sum(a**2))
    fit, unseen = halves(late(changed(base, lambda kinematics: mass * kinematics.acceleration), delay))
    found = diagnose(user_model, [fit], [unseen])
    assert found.verdict == "missing"
    assert {finding.phenomenon for finding in found.findings} == {"channel_skew", "inertia"}
    values = {fitted.name: fitted for finding in found.findings for fitted in finding.parameters}
    assert abs(values["channel_skew.skew"].value) == pytest.approx(delay, abs=1e-4)
    assert values["inertia.mass"].value == pytest.approx(mass, rel=0.03)
    for finding in found.findings:  # neither is credited with what only both explain
        assert finding.rmse_before_n == pytest.approx(found.rmse_n) and finding.rmse_after_n < 0.4 * found.rmse_n


@pytest.mark.parametrize(("delay", "friction"), [(0.002, 120.0), (0.003, 80.0)])
def test_a_single_effect_that_resembles_two_does_not_take_their_place(user_model, base, delay, friction):
    def stick(kinematics):
        v = kinematics.velocity
        return friction * v / np.sqrt(v**2 + 0.01**2)

    # A hysteresis that is ahead of the velocity leaves a quarter of the error that friction or a skew leaves alone.
    fit, unseen = halves(late(changed(base, stick), delay))
    found = diagnose(user_model, [fit], [unseen])
    assert found.verdict == "missing"
    assert {finding.phenomenon for finding in found.findings} == {"channel_skew", "friction"}
    values = {fitted.name: fitted for finding in found.findings for fitted in finding.parameters}
    assert abs(values["channel_skew.skew"].value) == pytest.approx(delay, abs=2e-4)
    for finding in found.findings:  # each has its own share of the fall
        assert not finding.partner
    steps = sorted((finding.rmse_before_n, finding.rmse_after_n) for finding in found.findings)
    assert steps[1][0] == pytest.approx(found.rmse_n)
    assert steps[0][0] == pytest.approx(steps[1][1]) and steps[0][1] < 0.15 * found.rmse_n


def test_one_effect_is_not_split_into_two(user_model, base):
    def groove(kinematics):
        x, v = kinematics.displacement, kinematics.velocity
        return -150.0 * v * np.exp(-((x / 0.006) ** 2))

    fit, unseen = halves(changed(base, groove))
    found = diagnose(user_model, [fit], [unseen])
    assert [finding.phenomenon for finding in found.findings][:1] == ["position_dependence"]
    assert len(found.findings) == 1


def test_two_are_found_where_the_model_has_always_erred_and_neither_is_found_alone(user_model, base):
    """The old error hides what is new from each single effect; both together stand out of it."""
    a, delay = base.kinematics.acceleration, 0.003
    slope = slope_of(user_model, base.kinematics.block)
    mass = 1.3 * delay * float(np.sum(slope * a**2) / np.sum(a**2))
    hidden = late(changed(base, lambda kinematics: mass * kinematics.acceleration), delay)
    old = 0.5 * float(np.std(hidden.force - base.force))
    fit, unseen = halves(replace(wandering(hidden, old), recording="another.mcap"))
    found = diagnose(erring(user_model, old), [fit], [unseen])
    assert {finding.phenomenon for finding in found.findings} == {"channel_skew", "inertia"}
    values = {fitted.name: fitted.value for finding in found.findings for fitted in finding.parameters}
    assert abs(values["channel_skew.skew"]) == pytest.approx(delay, abs=5e-4)
    assert values["inertia.mass"] == pytest.approx(mass, rel=0.1)


def test_two_are_not_found_in_an_old_error_alone(user_model, base):
    fit, unseen = halves(replace(wandering(base, 40.0), recording="another.mcap"))
    assert diagnose(erring(user_model, 40.0), [fit], [unseen]).findings == ()


def most(single: float, usual: float) -> float:
    """What a pair may leave beside a single effect, and an error that the model has always had."""
    hypothesis = SimpleNamespace(score=single, exclusion_alone="")
    data = SimpleNamespace(usual=usual, force_rms=500.0)
    baseline = SimpleNamespace(data=data)
    return pairs._most(SimpleNamespace(hypotheses=[hypothesis], baseline=baseline, refits=True), is_first=True)


@given(single=st.floats(0.01, 1.0), usual=st.floats(0.0, 1.0))
def test_a_pair_has_to_take_away_most_of_what_is_new(single, usual):
    alone = most(single, 0.0)
    assert alone == pytest.approx(0.6 * (single + 0.05) - 0.05)
    may_leave = most(single, usual)
    assert alone <= may_leave < max(single, alone + 1e-12)
    if may_leave > alone:  # it may not be credited with the usual error
        assert usual < may_leave
        assert may_leave - usual <= 0.6 * (single - usual) + 1e-12
