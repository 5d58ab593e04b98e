"""Candidates: every phenomenon has one, and each is physical whatever a recording drives."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planted import tried

from damper_estimator import Recording, diagnosis
from damper_estimator.diagnosis.hypotheses import hypotheses_for
from damper_estimator.effects.discovery import all_effects
from damper_estimator.effects.trial import Ranges
from damper_estimator.model import DamperModel, make_element, parse_model
from damper_estimator.model.element import new_element, walk

MODEL = DamperModel("plain", "", (make_element(all_effects()["viscous_curve"], {}),))


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False)


RANGES = st.builds(
    Ranges,
    compression=numbers(-0.3, -1e-3),
    extension=numbers(1e-3, 0.3),
    speed=numbers(1e-3, 6.0),
    acceleration=numbers(0.01, 500.0),
    force=numbers(1.0, 2e4),
    seconds=numbers(2.0, 3600.0),
    command=st.none() | st.tuples(numbers(0.0, 1.0), numbers(1.0, 20.0)),
    temperature=st.none() | st.tuples(numbers(-20.0, 40.0), numbers(41.0, 150.0)),
)


def test_every_phenomenon_has_a_candidate_where_its_channel_was_recorded():
    ranges = Ranges(-0.03, 0.04, 1.0, 50.0, 500.0, 60.0, (0.0, 2.0), (20.0, 60.0))
    found, _ = hypotheses_for(MODEL, ranges)
    assert {c.effect.phenomenon for c in found} == {e.phenomenon for e in all_effects().values() if e.phenomenon}


@settings(max_examples=60, deadline=None)
@given(RANGES)
def test_candidates_are_between_their_bounds_whatever_was_driven(ranges):
    found, untestable = hypotheses_for(MODEL, ranges)
    assert found and not {c.effect.name for c in found} & set(untestable)
    for hypothesis in found:
        model, free = hypothesis.added_to(MODEL)
        assert free
        for i in free:
            slot = model.slots[i]
            low, high = hypothesis.region.limits.get(slot.parameter.name, (slot.parameter.lower, slot.parameter.upper))
            assert slot.parameter.lower <= low < high <= slot.parameter.upper
            assert low <= slot.value <= high


def test_what_was_not_recorded_is_named():
    _, untestable = hypotheses_for(MODEL, Ranges(-0.03, 0.04, 1.0, 50.0, 500.0, 60.0))
    assert "temperature" in untestable["temperature_gain"]
    assert "command" in untestable["command_yield"]


HERE = Ranges(-0.03, 0.04, 1.0, 50.0, 500.0, 60.0)


def series_effects(springs):
    return [e for e in all_effects().values() if e.kind == "series" and e.is_series_spring == springs]


@pytest.mark.parametrize("passage", series_effects(springs=False), ids=lambda effect: effect.name)
def test_springs_are_tried_in_front_of_a_passage_and_no_passage_is(passage):
    model = DamperModel("bypassed", "", (make_element(passage, {}, MODEL.effects),))
    found, untestable = hypotheses_for(model, HERE)
    springs = [h for h in found if h.effect.kind == "series"]
    assert {h.effect for h in springs} == set(series_effects(springs=True))
    assert {effect.name for effect in series_effects(springs=False)} <= set(untestable)
    for hypothesis in springs:
        (outer,) = hypothesis.added_to(model)[0].effects
        assert outer.effect is hypothesis.effect and outer.path == model.effects


@pytest.mark.parametrize("stiffness", [2e5, 6e5])
def test_a_mount_that_became_soft_is_found_in_front_of_a_passage(stiffness):
    """The user's model has a leak in series with the valves; a mount was never looked for beside it."""
    rng, time = np.random.default_rng(3), np.arange(6000) / 500.0
    curve = {"viscous_curve": {"velocity": [-0.5, 0.0, 0.5], "force": [-900.0, 0.0, 1200.0]}}
    effects = [{"dashpot": {"damping": 2e4, "path": [curve]}}]
    model = parse_model({"name": "leaky", "source": "test", "effects": effects}, "test")
    mount = new_element(all_effects()["rubber_mount"], model.effects, {"stiffness": stiffness, "loss": 300.0})
    soft = model.with_missing(mount)

    def driven(part):
        tones = [(f, rng.uniform(0.5, 1.0), rng.uniform(0.0, 6.3)) for f in (0.7, 1.9, 4.1, 8.3, 13.0)]
        x = sum(0.012 * size / (1.0 + f) * np.sin(2.0 * np.pi * f * time + phase) for f, size, phase in tones)
        recording = Recording.from_arrays(time, x, force=np.zeros(time.size), name=part)
        (measurement,) = recording.measurements.values()
        return replace(measurement[0], force=soft.force(measurement[0].kinematics.block))

    found = diagnosis.diagnose(replace(model, fit={"bags": ["elsewhere"]}), [driven("fit")], [driven("unseen")])
    first = found.findings[0]
    assert first.phenomenon == "mount_compliance"
    assert first.rmse_after_n < 0.3 * first.rmse_before_n


@pytest.mark.parametrize("spring", series_effects(springs=True), ids=lambda effect: effect.name)
def test_passages_stand_behind_the_present_spring_and_are_not_tried_there(spring):
    model = DamperModel("soft", "", (make_element(spring, {}, MODEL.effects),))
    found, untestable = hypotheses_for(model, HERE)
    for passage in series_effects(springs=False):
        assert passage.name in untestable and passage not in {h.effect for h in found}
        (outer,) = model.with_missing(new_element(passage, model.effects)).effects
        assert outer.effect is spring and [e.effect for e in outer.path] == [passage]
        assert outer.path[0].path == MODEL.effects


def test_no_compliance_is_tried_where_one_is_in_a_single_path():
    spring, passage = (series_effects(springs=one)[0] for one in (True, False))
    inside = make_element(passage, {}, (make_element(spring, {}, MODEL.effects),))
    found, untestable = hypotheses_for(DamperModel("odd", "", (inside,)), HERE)
    assert not [h for h in found if h.effect.kind == "series"] and "in series" in untestable[spring.name]


@pytest.mark.parametrize("present", series_effects(springs=True), ids=lambda effect: effect.name)
def test_a_spring_takes_the_place_of_one_of_its_kind_and_stands_beside_the_other(present):
    soft = DamperModel("soft", "", (make_element(present, {}, MODEL.effects),))
    springs = [h for h in hypotheses_for(soft, HERE)[0] if h.effect.is_series_spring]
    assert {h.effect for h in springs} == set(series_effects(springs=True))
    for hypothesis in springs:
        model, free = hypothesis.added_to(soft)
        row = [one.effect for one in model.springs]
        if hypothesis.effect.of_oil == present.of_oil:
            assert row == [hypothesis.effect]
        else:
            assert row == sorted((present, hypothesis.effect), key=lambda effect: effect.of_oil)
        entries = list(walk(model.effects))
        assert free and all(entries[model.slots[i].entry].effect is hypothesis.effect for i in free)


def test_a_series_spring_is_tried_in_the_place_of_the_present_one():
    springs = [e for e in series_effects(springs=True) if e.of_oil]
    stiff = make_element(springs[0], {p.name: 3e6 for p in springs[0].parameters if p.unit == "N/m"}, MODEL.effects)
    found, _ = hypotheses_for(DamperModel("soft", "", (stiff,)), HERE)
    tried_springs = [hypothesis for hypothesis in found if hypothesis.effect in springs]
    assert {hypothesis.effect for hypothesis in tried_springs} == set(springs)
    for hypothesis in tried_springs:
        model, free = hypothesis.added_to(DamperModel("soft", "", (stiff,)))
        assert [e.effect for e in model.effects] == [hypothesis.effect] and model.effects[0].path == MODEL.effects
        assert free
        stiffness = [p.name for p in hypothesis.effect.parameters if p.unit == "N/m"]
        assert all(hypothesis.starts[-1][name] == 3e6 for name in stiffness), "one start is as stiff as the present one"


def test_what_is_missing_acts_in_parallel_to_all_that_is_there():
    gain = make_element(all_effects()["viscosity_gain"], {"rate": 0.02})
    friction = make_element(all_effects()["coulomb"])
    faded = DamperModel("faded", "", (*MODEL.effects, gain))
    assert faded.with_missing(friction).effects == (*MODEL.effects, gain, friction)
    assert faded.with_effect(friction).effects == (*MODEL.effects, friction, gain)


def test_scales_refer_to_where_the_model_was_identified():
    known = Ranges(-0.03, 0.04, 1.0, 50.0, 500.0, 60.0, (0.0, 2.0), (20.0, 60.0), (1.3, 1.3), (25.0, 29.0))
    unknown = replace(known, model_command=None, model_temperature=None)
    for effect, here, otherwise in (("viscosity_gain", 27.0, 20.0), ("command_gain", 1.3, 2.0)):
        for ranges, first in ((known, here), (unknown, otherwise)):
            hypothesis = next(h for h in hypotheses_for(MODEL, ranges)[0] if h.name == effect)
            assert hypothesis.element.settings["reference"] == first
            assert len({first, *(condition["reference"] for condition in hypothesis.conditions)}) >= 2


def test_the_package_names_no_effect_and_no_phenomenon():
    names = set(all_effects()) | {e.phenomenon for e in all_effects().values() if e.phenomenon}
    names -= {"path", "current"}  # ordinary words
    for source in Path(diagnosis.__path__[0]).glob("*.py"):
        tree = ast.parse(source.read_text(encoding="utf-8"))
        words = {
            node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
        assert not words & names, source


def test_a_fitted_hypothesis_goes_into_the_model_and_is_resumed_from_where_it_ended(noisy):
    hypothesis = tried(noisy, "coulomb", 0.5)
    (name,) = (parameter.name for parameter in hypothesis.effect.parameters if parameter.name == "force")
    ended = replace(hypothesis, fit=replace(hypothesis.fit, values={**hypothesis.fit.values, name: 123.0}))
    changed = ended.fitted_into(noisy.model)
    assert changed.effects[-1].parameters[name] == 123.0 and len(changed.effects) == len(noisy.model.effects) + 1
    again = ended.resumed(ended)
    assert again.fit is None and again.evaluation is None and again.element.parameters[name] == 123.0
    assert again.starts[-1][name] == hypothesis.element.parameters[name]
    for without_part in (
        replace(ended.fit, hidden=True),
        replace(ended.fit, change_fit=np.zeros_like(ended.fit.change_fit)),
    ):
        untouched = hypothesis.resumed(replace(ended, fit=without_part))
        assert untouched.element is hypothesis.element and untouched.fit is None
