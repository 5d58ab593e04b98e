"""What the evidence says of where and when an effect takes error away."""

import numpy as np
import pytest

from damper_estimator.diagnosis.baseline import baseline_of
from damper_estimator.diagnosis.diagnosis_data import data_of, targets
from damper_estimator.diagnosis.evaluation import errors, evaluated_tests
from damper_estimator.diagnosis.evidence import confirming, evidence
from damper_estimator.effects.discovery import find_effect
from damper_estimator.signals.layout import V


@pytest.fixture
def told(user_model, base):
    """Evidence where the share of the force that an effect takes away follows ``share`` (n,) over the recording."""

    def told(share):
        own = baseline_of(user_model, data_of(user_model, [base], [base]), base=())
        measured = own.data.unseen[0].measurement
        picks = own.data.unseen[0].picks
        left = targets(own.data.unseen) * np.sqrt(share(measured)[picks])
        without, with_it = (errors(own.data.blocks, own.residual_fit, one) for one in (left, 0.0 * left))
        return evidence(own, find_effect("coulomb"), without, with_it, evaluated_tests(own, "kept"))

    return told


def test_what_the_error_depends_on_is_said_with_the_best_other_test(told):
    text = told(lambda m: np.full(len(m.kinematics), 0.1))
    assert "depend" in text and "the best other one" in text


def test_the_speeds_that_lose_most_error_are_named(told):
    def fast_rebound(measurement):
        v = measurement.kinematics.block[V]
        return np.where(v > np.quantile(np.abs(v), 0.7), 0.3, 0.0)

    assert "lies in rebound between" in told(fast_rebound)


def test_the_test_that_tells_look_alikes_apart_names_them():
    effect = find_effect("coulomb")
    assert confirming(effect, ["oil compressibility", "inertia"]).startswith(
        "To distinguish it from oil compressibility or inertia: "
    )
    assert confirming(effect, []).lower().startswith(effect.separate[:10].lower())
