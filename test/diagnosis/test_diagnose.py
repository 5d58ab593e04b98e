"""What a diagnosis says of recordings in which the truth is known."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from faults import changed, erring, halves, late, wandering

from damper_estimator.diagnosis import diagnose, search, with_misfit
from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.thresholds import using
from damper_estimator.effects.discovery import find_effect
from damper_estimator.identification import fit as identify
from damper_estimator.model import DamperModel, load_model, make_element

KEYS = {"verdict", "rmse_n", "noise_floor_n", "findings", "rejected"}
FINDING_KEYS = {
    "effect", "phenomenon", "tied_with", "rmse_before_n", "rmse_after_n", "share_of_explainable_error", "confidence",
    "evidence", "test_to_separate", "parameters",
}  # fmt: skip


@pytest.fixture(scope="module")
def found_soft(user_model, soft):
    """The diagnosis of the shipped story."""
    return diagnose(user_model, [soft[0]], [soft[1]], workers=2)


def test_the_shipped_story_is_told_right(found_soft):
    first = found_soft.findings[0]
    assert found_soft.verdict == "missing"
    assert "oil_compressibility" in (first.phenomenon, *first.tied_with)
    assert first.rmse_after_n < 0.6 * first.rmse_before_n
    assert 0.75 <= first.confidence <= 1.0 and first.low > 0.25
    assert first.evidence and first.test_to_separate
    assert len(first.tied_with) <= 3


def test_the_record_has_the_documented_keys(found_soft):
    record = found_soft.record()
    assert KEYS <= set(record)
    assert FINDING_KEYS <= set(record["findings"][0])
    assert all(set(entry) >= {"effect", "reason"} and entry["reason"] for entry in record["rejected"])


def test_every_candidate_is_ranked_or_named_untestable(found_soft):
    judged = {j.effect for j in found_soft.ranking}
    assert not judged & set(found_soft.untestable)
    gains = [j.kept.gain for j in found_soft.ranking if j.kept and j.phenomenon != found_soft.findings[0].phenomenon]
    assert max(gains) <= found_soft.findings[0].gain + 0.03
    assert all(j.kept.low <= j.kept.high for j in found_soft.ranking if j.kept)


def test_only_findings_are_ranked_without_a_reason_against_them(user_model, base, monkeypatch):
    fit, unseen = halves(changed(base, lambda kinematics: 5000.0 * np.maximum(kinematics.displacement, 0.0) + 60.0))
    monkeypatch.setattr(ModelState, "delivers", lambda *_: False)
    assert all(row.reason for row in diagnose(user_model, [fit], [unseen]).ranking)


def test_a_finding_that_delivers_nothing_does_not_lower_what_is_left(user_model, soft, monkeypatch):
    monkeypatch.setattr(ModelState, "delivers", lambda *_: False)
    found = diagnose(user_model, [soft[0]], [soft[1]], mode="kept")
    assert found.verdict == "unexplained" and found.findings == ()
    assert f"error of {found.rmse_n:.3g} N" in found.sentence and "left of" not in found.sentence


def test_a_second_search_follows_an_effect_that_delivers_nothing(user_model, soft, found_soft, monkeypatch):
    module = import_module("damper_estimator.diagnosis.outcome")
    original, first = module.steps_of, found_soft.findings[0].effect

    def without_the_first(state, accepted, *arguments, **keywords):
        if accepted[0].element.effect.name == first:
            return []
        return original(state, accepted, *arguments, **keywords)

    monkeypatch.setattr(module, "steps_of", without_the_first)
    found = diagnose(user_model, [soft[0]], [soft[1]], mode="kept")
    assert found.verdict == "missing" and found.findings[0].effect != first
    reasons = {row.effect: row.reason for row in found.ranking}
    assert "does not lower the unseen error" in reasons[first] and found.ranking[0].reason == ""


@pytest.mark.parametrize(
    "static",
    [
        lambda v: -500.0 * np.maximum(np.abs(v) - 0.2, 0.0) * np.sign(v),
        lambda v: 250.0 * np.maximum(v, 0.0) - 150.0 * np.minimum(v, 0.0),
        lambda v: 80.0 * np.tanh(v / 0.05),
    ],
    ids=["beyond a speed", "one direction", "step"],
)
def test_a_change_of_the_curve_depends_on_nothing_but_velocity(static, user_model, base):
    fit, unseen = halves(changed(base, lambda k: static(k.velocity)))
    found = diagnose(user_model, [fit], [unseen]).findings
    named = {name for finding in found for name in (finding.phenomenon, *finding.tied_with)}
    assert named and not named & {"position_dependence", "temperature_fade", "current", "gas_spring", "end_stop"}


def test_nothing_is_found_where_nothing_is_missing(user_model, base):
    fit, unseen = halves(base)
    found = diagnose(user_model, [fit], [unseen])
    assert found.verdict == "nothing_missing" and found.findings == ()


def test_the_last_part_is_kept_back_where_nothing_else_is_given(user_model, base):
    found = diagnose(user_model, [base])
    unseen = found.unseen[0].kinematics.stamp[found.unseen[0].judged]
    assert found.fit[0].kinematics.stamp[-1] < unseen[0]
    assert unseen.size == pytest.approx(0.4 * len(base.kinematics), abs=1)


@pytest.mark.parametrize("seconds", [-0.004, -0.001, 0.001, 0.003])
def test_a_late_force_is_the_channels_and_told_in_milliseconds(user_model, base, seconds):
    fit, unseen = halves(late(base, seconds))
    found = diagnose(user_model, [fit], [unseen])
    first = found.findings[0]
    assert first.phenomenon == "channel_skew" and first.tied_with == () and first.is_channel
    assert found.signals.force.skew == pytest.approx(seconds, abs=3e-4)
    assert found.improved.channel_effects == []


def test_a_changed_parameter_is_no_missing_effect(user_model, base):
    stiffer = {s.address: 1.3 * s.value for s in user_model.slots if s.address.startswith("viscous_curve.force")}
    truth = user_model.with_values(stiffer)
    before = user_model.force(base.kinematics.block)
    fit, unseen = halves(changed(base, lambda k: truth.force(k.block) - before))
    found = diagnose(user_model, [fit], [unseen])
    assert found.verdict == "parameters_changed"
    assert {m.name for m in found.moved} <= {s.address for s in user_model.slots}
    assert sum(m.name.startswith("viscous_curve") for m in found.moved) >= 3
    assert all(np.isfinite(m.standard_error) for m in found.moved)
    assert found.rmse_refit_alone_n < 0.5 * found.rmse_n


def test_a_stiffness_that_was_next_to_rigid_is_found_again(user_model, soft):
    values = {"stiffness_rebound": 6e7, "stiffness_compression": 6e7}
    stiff = make_element(find_effect("oil_spring"), values, user_model.effects)
    found = diagnose(replace(user_model, effects=(stiff,)), [soft[0]], [soft[1]])
    assert found.verdict == "parameters_changed"
    values = {moved.name: moved.after for moved in found.moved}
    assert all(5e5 < values[f"oil_spring.stiffness_{way}"] < 4e6 for way in ("rebound", "compression"))
    assert found.rmse_refit_alone_n < 0.3 * found.rmse_n


def test_a_user_who_trusts_his_parameters_is_told_the_phenomenon(user_model, base):
    friction = next(s for s in user_model.slots if s.address == "dahl.force")
    truth = user_model.with_values({"dahl.force": friction.value + 60.0})
    before = user_model.force(base.kinematics.block)
    fit, unseen = halves(changed(base, lambda k: truth.force(k.block) - before))
    found = diagnose(user_model, [fit], [unseen], mode="kept")
    assert found.verdict == "missing" and found.findings[0].phenomenon == "friction"


def test_structure_that_no_effect_has_is_shown_and_not_named(user_model, base):
    """A ripple over the stroke, as of a scored tube."""
    fit, unseen = halves(changed(base, lambda k: 70.0 * np.sin(2.0 * np.pi * k.displacement / 0.012)))
    found = diagnose(user_model, [fit], [unseen])
    assert found.verdict == "unexplained" and found.findings == ()
    assert "displacement (m)" in found.structure.axes and np.isfinite(found.structure.mean_n).any()


def test_more_noise_is_no_effect(user_model, base):
    noise = np.random.default_rng(0).normal(0.0, 40.0, len(base.kinematics))
    fit, unseen = halves(changed(base, lambda k: noise))
    assert diagnose(user_model, [fit], [unseen]).findings == ()


def test_the_gauges_zero_is_a_mistake_of_the_chain(user_model, base):
    fit, unseen = halves(changed(base, lambda k: np.full(len(k), 60.0)))
    found = diagnose(user_model, [fit], [unseen])
    assert [f.phenomenon for f in found.findings] == ["force_offset"]
    assert found.signals.force.offset == pytest.approx(-60.0, abs=8.0)


def test_the_gauges_zero_is_found_beside_an_error_that_is_not_new(user_model, base):
    model, old = erring(user_model, 30.0), replace(wandering(base, 24.0), recording="another.mcap")
    fit, unseen = halves(old)
    assert diagnose(model, [fit], [unseen]).verdict == "nothing_missing"
    fit, unseen = halves(changed(old, lambda k: np.full(len(k), 28.0)))
    found = diagnose(model, [fit], [unseen])
    assert [one.phenomenon for one in found.findings] == ["force_offset"]
    assert found.signals.force.offset == pytest.approx(-28.0, abs=5.0)


def test_a_mean_that_the_damper_may_make_is_tied_with_the_gauges_zero(user_model, base):
    """A force that is the same at nearly all speeds, in both directions: next to no data lie where it is not."""
    fit, unseen = halves(changed(base, lambda k: 60.0 * np.tanh(np.abs(k.velocity) / 0.002)))
    first = diagnose(user_model, [fit], [unseen]).findings[0]
    assert first.phenomenon == "force_offset" and "asymmetry" in first.tied_with


def test_an_even_force_that_low_speeds_show_is_no_zero(user_model, base):
    fit, unseen = halves(changed(base, lambda k: 60.0 * np.tanh(np.abs(k.velocity) / 0.03)))
    first = diagnose(user_model, [fit], [unseen]).findings[0]
    assert first.phenomenon == "asymmetry" and "force_offset" not in first.tied_with


def test_zeros_that_differ_between_recordings_hide_nothing(user_model, soft):
    """Every recording was tared by itself: its zero belongs to it."""
    shifted = replace(soft[1], force=soft[1].force + 25.0)
    found = diagnose(user_model, [soft[0]], [shifted])
    first = found.findings[0]
    assert "oil_compressibility" in (first.phenomenon, *first.tied_with)


@pytest.mark.parametrize(
    ("phenomenon", "hidden", "seconds"),
    [
        ("spring_rate_error", lambda k: 8000.0 * k.displacement, 0.0025),
        ("friction", lambda k: 80.0 * np.tanh(k.velocity / 0.01), 0.004),
    ],
)
def test_two_at_once_are_both_found(phenomenon, hidden, seconds, user_model, base):
    fit, unseen = halves(late(changed(base, hidden), seconds))
    found = diagnose(user_model, [fit], [unseen])
    assert [one.phenomenon for one in found.findings] == ["channel_skew", phenomenon]
    assert found.signals.force.skew == pytest.approx(seconds, abs=3e-4)


def test_a_zero_is_told_beside_an_effect_with_a_mean(user_model, base):
    def hidden(kinematics):
        return 5000.0 * np.maximum(kinematics.displacement, 0.0) + 60.0

    fit, unseen = halves(changed(base, hidden))
    found = diagnose(user_model, [fit], [unseen])
    names = [one.phenomenon for one in found.findings]
    assert "force_offset" in names and len(names) > 1
    assert found.signals.force.offset == pytest.approx(-60.0, abs=15.0)


def test_findings_end_at_the_most_that_are_looked_for(user_model, soft, monkeypatch):
    monkeypatch.setattr(search, "MOST", 1)
    assert len(diagnose(user_model, [soft[0]], [soft[1]]).findings) == 1


def test_the_number_of_workers_changes_nothing(user_model, soft):
    one, two = (diagnose(user_model, [soft[0].part(0, 3000)], [soft[1].part(0, 3000)], workers=n) for n in (1, 2))
    assert one.record() == two.record()


def test_progress_rises_and_can_cancel(user_model, base):
    class Enough(Exception):
        pass

    heard: list[float] = []

    def listen(text: str, share: float) -> None:
        heard.append(share)
        if len(heard) > 5:
            raise Enough

    with pytest.raises(Enough):
        diagnose(user_model, [base], progress=listen, workers=2)
    assert heard == sorted(heard) and 0.0 <= heard[0] and heard[-1] <= 1.0


def test_an_unknown_mode_is_refused(user_model: DamperModel, base):
    with pytest.raises(ValueError, match="mode"):
        diagnose(user_model, [base], mode="free")


def test_a_usual_error_that_has_not_grown_is_no_finding_on_other_recordings(base):
    """The model has lacked a curve since it was identified, on another recording of the damper."""
    rough = load_model("linear_viscous")
    count = len(base.kinematics) // 6
    first, *others = (base.part(k * count, (k + 1) * count) for k in range(3))
    model = with_misfit(identify(rough, [first], starts=1).model, [first])
    fit, unseen = (replace(part, recording="other.mcap") for part in others)
    with using(usual=0.9, growth=6.0):
        found = diagnose(model, [fit], [unseen])
        assert found.verdict == "nothing_missing" and not found.findings and "is new" in found.sentence
        assert any("always been missing" in ranked.reason for ranked in found.ranking)
        # What it has always lacked is found on the recording of its identification.
        assert diagnose(model, [first], [unseen]).verdict == "missing"
        # A change is found.
        stiffer = [changed(m, lambda k: 2e5 * k.displacement) for m in (fit, unseen)]
        assert diagnose(model, stiffer[:1], stiffer[1:]).verdict == "missing"
