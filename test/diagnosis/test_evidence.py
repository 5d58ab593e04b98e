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
def sentences(user_model, base):
    """Evidence where the share of the force that an effect takes away follows ``share`` (n,) over the recording."""

    def sentences(share):
        baseline = baseline_of(user_model, data_of(user_model, [base], [base]), base=())
        measured = baseline.data.unseen[0].measurement
        picks = baseline.data.unseen[0].picks
        left = targets(baseline.data.unseen) * np.sqrt(share(measured)[picks])
        without, with_it = (errors(baseline.data.blocks, baseline.residual_fit, one) for one in (left, 0.0 * left))
        return evidence(baseline, find_effect("coulomb"), without, with_it, evaluated_tests(baseline, "kept"))

    return sentences


def test_what_the_error_depends_on_is_said_with_the_best_other_test(sentences):
    text = sentences(lambda m: np.full(len(m.kinematics), 0.1))
    assert "depend" in text and "the best other one" in text


def test_the_speeds_that_lose_most_error_are_named(sentences):
    def fast_rebound(measurement):
        v = measurement.kinematics.block[V]
        return np.where(v > np.quantile(np.abs(v), 0.7), 0.3, 0.0)

    assert "lies in rebound between" in sentences(fast_rebound)


def test_the_test_that_tells_look_alikes_apart_names_them():
    effect = find_effect("coulomb")
    assert confirming(effect, ["oil compressibility", "inertia"]).startswith(
        "To distinguish it from oil compressibility or inertia: "
    )
    assert confirming(effect, []).lower().startswith(effect.separate[:10].lower())
