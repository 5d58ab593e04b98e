"""A zero of the gauge that moves during a recording."""

from dataclasses import replace

import numpy as np
import pytest
from faults import changed, halves

from damper_estimator.diagnosis import diagnose, improve
from damper_estimator.diagnosis.apply_finding import state_of
from damper_estimator.diagnosis.moving_zero import moving_zero, steadied
from damper_estimator.signals.layout import TEMPERATURE


def share(k):
    """(n,) from 0 to 1 over a recording."""
    return (k.time - k.time[0]) / (k.time[-1] - k.time[0])


MOVEMENTS = {
    "creeps": lambda k: 1.0 - np.exp(-5.0 * share(k)),
    "jumps": lambda k: (share(k) > 0.55).astype(float),
    "wanders": lambda k: 0.5 * np.sin(5.0 * share(k)),
}


def moved(measurement, form, newtons=300.0):
    """The measurement with a zero that moves by so much, about a mean of 0."""
    return changed(measurement, lambda k: newtons * (MOVEMENTS[form](k) - MOVEMENTS[form](k).mean()))


@pytest.mark.parametrize("form", MOVEMENTS)
def test_a_zero_that_moves_is_seen_whatever_its_form(form, user_model, base):
    faulty = moved(base, form)
    found = moving_zero(user_model, faulty)
    assert found is not None
    line = faulty.force - base.force
    left = np.std((line - found.line)[base.judged]) / np.std(line[base.judged])
    assert left < (0.6 if form == "jumps" else 0.35)
    assert found.line[base.judged].mean() == pytest.approx(0.0, abs=1e-6)


def test_a_zero_that_stands_still_is_left_alone(user_model, base, soft):
    for measurement in (base, *soft):
        assert moving_zero(user_model, measurement) is None


@pytest.mark.parametrize(
    "effect",
    [
        lambda k: 6000.0 * k.displacement,
        lambda k: -0.3 * share(k) * 1500.0 * k.velocity,
        lambda k: 250.0 * np.tanh(k.velocity / 0.01),
        lambda k: 60.0 * k.acceleration,
    ],
)
def test_an_effect_of_the_damper_is_no_movement(effect, user_model, base):
    found = moving_zero(user_model, changed(base, effect))
    assert found is None or found.share < 0.1


def test_gas_that_warms_is_no_movement(user_model, base):
    """The force follows the temperature, which the recording has: the effects of temperature are tried."""
    k = base.kinematics
    block = k.block.copy()
    block[TEMPERATURE] = 20.0 + 25.0 * share(k)
    warm = replace(base, kinematics=replace(k, block=block), force=base.force - 300.0 * share(k))
    assert moving_zero(user_model, warm) is None


def test_what_is_missing_beside_a_moving_zero_is_found(user_model, base):
    """The zero moves by more than the spring changes the force."""
    stiffer = changed(base, lambda k: 6000.0 * k.displacement)
    found = diagnose(user_model, [moved(stiffer, "creeps", 600.0)], halves(stiffer)[1:])
    assert "The gauge's zero moves" in found.sentence
    assert "spring_rate_error" in {found.findings[0].phenomenon, *found.findings[0].tied_with}
    (parameter,) = [one for finding in found.findings for one in finding.parameters if one.unit == "N/m"]
    assert abs(parameter.value) == pytest.approx(6000.0, rel=0.1)


def test_the_recordings_themselves_stay_as_they_are(user_model, base):
    fit, unseen = moved(base, "jumps"), moved(base, "wanders")
    state = state_of(user_model, [fit], [unseen])
    steady, found = steadied(state)
    assert {one.recording for one in found} == {base.recording}
    assert steady.unseen[0] is state.unseen[0] and steady.rmse_unseen_n == state.rmse_unseen_n
    assert np.ptp(steady.unseen_part[0].force - state.unseen_part[0].force) > 100.0


def test_a_zero_that_wanders_about_its_mean_is_a_finding_that_nothing_corrects(user_model, base):
    fit, unseen = moved(base, "jumps", 600.0), moved(base, "wanders", 600.0)
    result = improve(user_model, [fit], [unseen])
    first = result.first
    (finding,) = first.findings
    assert (first.verdict, finding.phenomenon, finding.parameters) == ("missing", "force_offset", ())
    assert finding.rmse_after_n < 0.7 * finding.rmse_before_n
    assert finding.low > 0.5 * finding.gain
    assert "no correction of the signal map follows it" in finding.remark
    assert [step.action for step in result.steps] == ["start"]
    assert result.sentence.startswith("Nothing was added: The gauge's zero moves")


def test_a_small_movement_is_said_but_is_no_finding(user_model, base):
    """Below 3 % of the force: good gauges drift by as much."""
    newtons = 0.04 * float(np.std(base.force))
    found = diagnose(user_model, [moved(base, "creeps", newtons)], [moved(base, "wanders", newtons)])
    assert "force_offset" not in {one.phenomenon for one in found.findings}
