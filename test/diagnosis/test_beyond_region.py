"""What a diagnosis says of an error outside the region that the model was identified in."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis import diagnose
from damper_estimator.diagnosis.apply_finding import state_of
from damper_estimator.diagnosis.beyond_region import extrapolation, inside_region
from damper_estimator.diagnosis.search import NOT_IDENTIFIED_THERE
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import V, X


def identified(model: DamperModel, **region: object) -> DamperModel:
    """The model with another region in its record."""
    return replace(model, fit={**model.fit, "region": region})


@pytest.fixture(scope="session")
def wrong_at_the_ends(user_model: DamperModel, base: Measurement) -> Measurement:
    """The recording with a force that the model does not know, in the outer half of the stroke only."""
    x = base.kinematics.block[X]
    middle, half = 0.5 * (x.max() + x.min()), 0.5 * np.ptp(x)
    more = 2e4 * np.maximum(np.abs(x - middle) - 0.5 * half, 0.0) * np.sign(x - middle)
    return replace(base, force=user_model.force(base.kinematics.block) + more)


def test_an_error_where_the_model_was_never_identified_is_called_one_of_extrapolation(user_model, wrong_at_the_ends):
    x = wrong_at_the_ends.kinematics.block[X]
    middle, half = 0.5 * (x.max() + x.min()), 0.5 * np.ptp(x)
    region = [middle - 0.45 * half, middle + 0.45 * half]
    model = identified(user_model, displacement=region, velocity=[-9.0, 9.0])
    sentence = extrapolation(state_of(model, [wrong_at_the_ends], [wrong_at_the_ends])).sentence
    assert f"{1e3 * region[0]:.3g} to {1e3 * region[1]:.3g} mm" in sentence and "displacement" in sentence
    assert int(sentence.split(" %")[0]) > 95


def test_the_same_error_inside_the_region_is_none(user_model, wrong_at_the_ends):
    assert extrapolation(state_of(user_model, [wrong_at_the_ends], [wrong_at_the_ends])) is None


def test_an_error_that_is_everywhere_is_none_of_extrapolation(user_model, base):
    force = user_model.force(base.kinematics.block) + 100.0 * np.sin(40.0 * base.kinematics.time)
    everywhere = replace(base, force=force)
    narrow = identified(user_model, displacement=[-1e-3, 1e-3], velocity=np.quantile(
        base.kinematics.block[V], [0.3, 0.7]).tolist())  # fmt: skip
    assert extrapolation(state_of(narrow, [everywhere], [everywhere])) is None


@pytest.mark.parametrize("region", [None, "wide", {}, {"displacement": 3.0}, {"displacement": ["a", "b"]}])
def test_a_record_that_was_edited_by_hand_is_no_error(user_model, wrong_at_the_ends, region):
    model = replace(user_model, fit={**user_model.fit, "region": region})
    assert extrapolation(state_of(model, [wrong_at_the_ends], [wrong_at_the_ends])) is None


@pytest.fixture
def slow_model(user_model, base):
    """The model as if it had been identified at the slower half of the speeds."""
    ends = np.quantile(base.kinematics.block[V], [0.2, 0.8]).tolist()
    return identified(user_model, displacement=[-9.0, 9.0], velocity=ends), ends


def yielding(base, ends, force):
    """The recording with a force that yields where the model was never identified."""
    v = base.kinematics.block[V]
    beyond = np.maximum(v - ends[1], 0.0) + np.minimum(v - ends[0], 0.0)
    return replace(base, force=force - 1500.0 * beyond)


def test_what_is_missing_everywhere_is_found_under_an_error_of_extrapolation(slow_model, base):
    model, ends = slow_model
    x = base.kinematics.block[X]
    both = yielding(base, ends, base.force + 9000.0 * (x - np.median(x)))
    found = diagnose(model, [both], [both])
    assert "outside the velocity" in found.sentence
    assert found.findings[0].phenomenon == "spring_rate_error"
    assert found.findings[0].rmse_before_n == pytest.approx(found.rmse_n), "errors are those of the whole recording"


def test_what_only_extrapolation_shows_is_named_with_the_warning(slow_model, base):
    model, ends = slow_model
    found = diagnose(model, [yielding(base, ends, base.force)], [yielding(base, ends, base.force)])
    assert "outside the velocity" in found.sentence and found.findings[0].phenomenon == "blow_off"


def test_what_begins_only_far_beyond_the_velocities_of_the_identification_is_ranked_but_not_named(slow_model, base):
    """A curve that goes on otherwise than it was identified looks like a blow-off valve."""
    model, ends = slow_model
    outside = [yielding(base, [3.0 * end for end in ends], base.force)]
    found = diagnose(model, outside, outside)
    assert "outside the velocity" in found.sentence and "At the velocities that it was identified at" in found.sentence
    assert found.verdict == "nothing_missing" and not found.findings
    best = max(found.ranking, key=lambda row: row.kept.gain if row.kept else 0.0)
    assert best.phenomenon == "blow_off" and best.reason == NOT_IDENTIFIED_THERE
    asked = diagnose(model, outside, outside, mode="kept")
    assert "outside the velocity" in asked.sentence and asked.findings[0].phenomenon == "blow_off"


def test_inside_is_what_the_model_was_identified_at(slow_model, base):
    model, ends = slow_model
    outside = yielding(base, ends, base.force)
    state = state_of(model, [outside], [outside])
    inside = inside_region(state, extrapolation(state))
    v = base.kinematics.block[V]
    assert np.array_equal(inside.fit[0].judged, base.judged & (v >= ends[0]) & (v <= ends[1]))
    assert inside.rmse_unseen_n < 0.5 * state.rmse_unseen_n
    assert extrapolation(state_of(model, [base], [base])) is None
