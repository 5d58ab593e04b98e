"""Two effects that cancel where the curve is straight are found together, with their values."""

import numpy as np
import pytest
from faults import changed, halves, late

from damper_estimator.diagnosis import diagnose
from damper_estimator.diagnosis.diagnosis_data import slope_of


@pytest.mark.parametrize(("delay", "share"), [(0.003, 1.0), (0.002, 1.3)])
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
