"""What a model already got wrong when it was identified is not new."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from faults import changed, halves

from damper_estimator.diagnosis import apply_finding, diagnose, improve, with_misfit
from damper_estimator.diagnosis.accepted import accepted_in
from damper_estimator.diagnosis.apply_finding import state_of
from damper_estimator.diagnosis.diagnosis_data import force_rows, targets
from damper_estimator.diagnosis.known_error import without_misfit
from damper_estimator.diagnosis.misfit import (
    IMPROVED,
    KEY,
    ZERO,
    has_grown,
    misfit_of,
    probability_of_change,
    usual_bound,
    usual_share,
)
from damper_estimator.diagnosis.search import TOO_SMALL
from damper_estimator.identification import fit, rows_of
from damper_estimator.model import load_model, parse_model
from damper_estimator.model.model_files import model_yaml
from damper_estimator.signals import SignalMap, default_signals
from damper_estimator.signals.channels import ChannelData
from damper_estimator.signals.measurement import measured


@pytest.fixture(scope="module")
def rough(base):
    """A straight line for a damper with a curve, gas, friction and soft oil, and the recording it was made on."""
    first, other = halves(base)
    model = fit(load_model("linear_viscous"), [first], starts=1).model
    return with_misfit(model, [first]), first, other


def error(model, measurement):
    left = measurement.in_band(model.force(measurement.kinematics.block) - measurement.force)
    return float(np.std(left[measurement.judged]))


def test_the_old_error_is_predicted_on_a_recording_that_was_not_seen(rough):
    model, _, other = rough
    assert error(model, without_misfit(model, other)) < 0.3 * error(model, other)


def test_only_an_error_that_has_grown_clearly_is_news(rough):
    model, _, other = rough
    known = misfit_of(model.fit)
    usual = error(model, without_misfit(model, other)) / float(np.std(other.force[other.judged]))
    assert known.left == pytest.approx(usual, rel=0.3) and not known.leaves_more(known.left)
    assert known.leaves_more(1.5 * known.left) and not known.leaves_more(1.3 * known.left)
    assert replace(known, left=float("nan")).leaves_more(1.0)  # of an earlier version: unknown
    share = model.fit["residual_stddev"] / model.fit["force_rms"]
    assert not has_grown(model, 1.3 * share) and has_grown(model, 1.5 * share)
    assert has_grown(replace(model, fit={}), 0.01)


def test_what_improve_left_is_nothing_new_however_large_it_is(rough):
    model, _, other = rough
    parts = [replace(part, recording="other.mcap") for part in halves(other)]
    # As an unknown effect would make it: large, and nothing that the model is known to get wrong.
    bare = replace(model, fit={name: value for name, value in model.fit.items() if name not in (KEY, ZERO)})
    assert usual_bound(bare) < error(bare, other) / float(np.std(other.force[other.judged]))
    assert diagnose(bare, parts[:1], parts[1:]).verdict == "missing"
    left = replace(bare, fit={**bare.fit, IMPROVED: True})
    assert diagnose(left, parts[:1], parts[1:]).verdict == "nothing_missing"
    # As with any model, only until it grows.
    worse = [changed(part, lambda k: 15.0 * k.acceleration) for part in parts]
    assert diagnose(left, worse[:1], worse[1:]).findings


@pytest.mark.parametrize(
    ("then", "now", "share"),
    [(0.05, 0.1, 0.25), (0.1, 0.1, 1.0), (0.2, 0.1, 1.0), (np.nan, 0.1, 0.0)],
)
def test_the_share_of_an_error_that_is_usual(then, now, share):
    assert usual_share(then, now) == pytest.approx(share)


def test_it_survives_the_model_file(rough):
    import yaml

    model, _, other = rough
    again = parse_model(yaml.safe_load(model_yaml(model)), model.name)
    first, second = (without_misfit(one, other).force for one in (model, again))
    np.testing.assert_allclose(first, second, rtol=1e-4, atol=1e-3)


def test_a_model_that_errs_by_noise_only_keeps_nothing(user_model, base):
    block = base.kinematics.block
    noise = np.random.default_rng(3).normal(0.0, 20.0, block.shape[1])
    noisy = replace(base, force=user_model.force(block) + noise)
    assert KEY not in with_misfit(user_model, [noisy]).fit


@pytest.mark.parametrize("broken", [None, 3, {}, {"newtons": {"curve": ["x"]}}, {"newtons": {}, "speed": 1.0}])
def test_a_record_that_is_something_else_counts_as_none(user_model, broken):
    assert misfit_of({KEY: broken}) is None


@pytest.mark.parametrize(
    "record", [{"force_rms": "much"}, {"force_rms": None}, {"residual_stddev": []}, {"bags": None}, {"bags": 3}]
)
def test_a_record_that_was_edited_by_hand_counts_as_unknown(rough, record):
    model, first, other = rough
    edited = replace(model, fit={**model.fit, **record})
    assert has_grown(edited, 0.01) or "bags" in record
    assert state_of(edited, [first], [other]).is_identified_here == ("bags" not in record)


def test_a_poor_prediction_of_the_part_that_is_kept_back_is_no_change(rough):
    model, first, other = rough
    worse = changed(other, lambda kinematics: 2000.0 * kinematics.velocity)
    assert state_of(model, [first], [worse]).is_identified_here
    worse = changed(first, lambda kinematics: 2000.0 * kinematics.velocity)
    assert not state_of(model, [worse], [other]).is_identified_here


def test_what_came_since_is_found_beneath_a_larger_old_error(rough):
    """The straight line errs by more than is hidden, and in other ways."""
    model, _, other = rough
    fitted, unseen = halves(changed(other, lambda k: 1.2 * k.acceleration))
    hidden = float(np.std(other.in_band(1.2 * other.kinematics.acceleration)))
    assert error(model, other) > 2.0 * hidden
    found = diagnose(model, [fitted], [unseen])
    assert found.verdict == "missing"
    assert found.findings[0].phenomenon == "inertia"


@pytest.mark.parametrize(
    ("share", "mode", "is_named"), [(0.024, "both", False), (0.024, "kept", True), (0.05, "both", True)]
)
def test_a_small_error_is_named_only_on_demand(user_model, base, share, mode, is_named):
    """However much it has grown: models that err by 1 % on one motion err by more on another one."""
    model, (first, other) = with_misfit(user_model, [base]), halves(base)
    mass = share * float(np.std(base.force)) / float(np.std(base.kinematics.acceleration))
    heavier = [changed(part, lambda k: mass * k.acceleration) for part in (first, other)]
    found = diagnose(model, heavier[:1], heavier[1:], mode=mode)
    assert (found.verdict == "missing") == is_named
    assert [finding.phenomenon for finding in found.findings] == ["inertia"] * is_named
    of_a_mass = next(row for row in found.ranking if row.effect == "inertia")
    assert of_a_mass.kept.gain > 0.5 and (of_a_mass.reason == TOO_SMALL) == (not is_named)
    assert is_named or "though still below 3 % of the force" in found.sentence


def test_the_more_an_error_has_grown_the_more_probable_is_a_change(rough):
    model, _, _ = rough
    share = model.fit["residual_stddev"] / model.fit["force_rms"]
    growths = np.array([0.2, 1.0, 1.5, 2.0, 4.0, 8.0, 20.0])
    chances = [probability_of_change(model, share * np.sqrt(growth)) for growth in growths]
    assert chances == sorted(chances) and chances[0] == chances[2] > 0.0
    # Twice the squared error is not new, twenty times is.
    assert chances[3] < 0.5 and chances[-1] > 0.99
    assert probability_of_change(replace(model, fit={}), 0.01) == 1.0


def test_a_prediction_that_is_not_finite_changes_nothing(rough):
    model, _, other = rough
    known = dict(model.fit[KEY])
    broken = replace(model, fit={**model.fit, KEY: {**known, "newtons": {"shift": [float("nan")]}}})
    assert np.array_equal(without_misfit(broken, other).force, other.force)


def test_a_model_without_a_finite_force_has_an_infinite_error(rough, monkeypatch):
    model, first, other = rough
    state = state_of(model, [first], [other])
    monkeypatch.setattr(apply_finding, "pooled_error", lambda model, group: (float("nan"), 0.0, 0.0))
    worse = state.with_model(model)
    assert worse.rmse_unseen_n == float("inf") and not worse.delivers(1.0, state) and not worse.better_than(state)
    assert min((worse, state), key=lambda one: one.rmse_unseen_n) is state


@pytest.fixture
def finding_a_zero(monkeypatch):
    """Makes the search beneath the old error find a zero only: so many times the mean of the measured error."""
    module = import_module("damper_estimator.diagnosis.outcome")
    original = module.search

    def make(size):
        def only_a_zero(*arguments, trusted=False, **keywords):
            found = original(*arguments, trusted=trusted, **keywords)
            if not trusted:
                return found
            first = found.first
            zero, data = first.hidden[0], first.baseline.data.with_zero
            error = size * float(np.mean(targets(data.unseen) - force_rows(first.baseline.model, data.unseen)))
            fit = replace(zero.fit, values={"offset": error})
            one = replace(zero, fit=fit, evaluation=first.hypotheses[0].evaluation)
            first = replace(first, constants=frozenset({zero.name}))
            return replace(found, first=first, accepted=(accepted_in(first, one),))

        monkeypatch.setattr(module, "search", only_a_zero)
        return module.first_search

    return make


def elsewhere(state):
    """The state, with a model that was identified on another recording."""
    return replace(state, model=replace(state.model, fit={**state.model.fit, "bags": ["elsewhere.mcap"]}))


@pytest.mark.parametrize("is_here", [True, False])
def test_a_zero_alone_does_not_hide_what_a_model_lacks_on_the_recordings_of_its_fit(rough, finding_a_zero, is_here):
    """Beneath the old error only a zero is found: new elsewhere, but not where the model was identified."""
    model, first, other = rough
    state = state_of(model, [first], [changed(other, lambda kinematics: 900.0 * kinematics.velocity)])
    if not is_here:
        state = elsewhere(state)
    assert state.is_identified_here == is_here
    found, _ = finding_a_zero(1.0)(state, "both")
    assert found.mode == ("refit" if is_here else "both")


@pytest.mark.parametrize(("size", "is_new"), [(1.0, True), (-1.0, False)])
def test_a_mean_of_the_old_error_that_is_missing_here_is_no_new_zero(rough, finding_a_zero, size, is_new):
    """It would raise the error as measured."""
    model, first, other = rough
    state = elsewhere(state_of(model, [first], [changed(other, lambda kinematics: 900.0 * kinematics.velocity)]))
    found, _ = finding_a_zero(size)(state, "both")
    assert ([one.element.effect.name for one in found.accepted] == ["force_offset"]) == is_new


def test_a_prediction_is_the_same_where_the_recording_is_thinned():
    """Its columns hold rates of the force and accelerations, whose noise must not fold into the band."""
    rng, rate = np.random.default_rng(1), 3000.0
    time = np.arange(0.0, 15.0, 1.0 / rate)
    x = 0.01 * np.sin(2.0 * np.pi * 1.3 * time) + 6e-5 * rng.standard_normal(time.size)
    stamp, number = np.round(1e9 * time).astype(np.int64), np.arange(time.size)
    channels = {"displacement": ChannelData(stamp, number, x), "force": ChannelData(stamp, number, 0.0 * x)}
    recording = measured("fast", "front", channels, SignalMap(60.0, 30.0, {"front": default_signals("front")}))
    record = {"compression": -0.01, "extension": 0.01, "speed": 0.1, "newtons": {"lags": [1.0] * 7}}
    model = replace(load_model("linear_viscous"), fit={KEY: record})
    rows = rows_of(without_misfit(model, recording))
    whole, thinned = (float(np.std(part.target)) for part in (rows, rows.thinned()))
    in_band = recording.in_band(misfit_of(model.fit).force(model, recording))
    assert whole == pytest.approx(float(np.std(in_band[rows.picks])), rel=0.01)
    assert thinned == pytest.approx(whole, rel=0.03)


def test_a_zero_that_was_corrected_in_the_signal_map_is_not_new_without_the_correction(user_model, base):
    """`improve` finds a zero of 300 N; the next recordings are read through the map without its correction."""

    def recorded_with(newtons):
        return [replace(part, recording="next.mcap") for part in halves(changed(base, lambda k: newtons))]

    first, second = halves(changed(base, lambda k: 300.0))
    result = improve(user_model, [first], [second])
    assert [step.action for step in result.steps] == ["start", "correct"]
    mean = float(np.mean(misfit_of(result.model.fit).force(result.model, first)[first.judged]))
    assert result.model.fit[ZERO] + mean == pytest.approx(300.0, abs=5.0)
    for newtons, is_new in {300.0: False, 150.0: False, 0.0: False, 700.0: True, -300.0: True}.items():
        fit, unseen = recorded_with(newtons)
        found = diagnose(result.model, [fit], [unseen])
        assert ("force_offset" in {one.phenomenon for one in found.findings}) == is_new, newtons
