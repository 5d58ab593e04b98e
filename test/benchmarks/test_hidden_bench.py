"""The hidden-effect bench: its figures are correct and its cases match their names."""

import json
import pickle
from math import isnan
from types import SimpleNamespace

import bench_hidden
import hidden_cases
import hidden_plans
import hidden_tables
import hidden_verdicts
import numpy as np
import pytest

from damper_estimator.model import load_model
from damper_estimator.plant import PHENOMENA, Calibration


def record(hidden=("friction",), named=(("friction",),), verdict="missing", **more):
    """A record like a line of the results; ``named`` is the group of each finding, its phenomenon first."""
    return {
        "name": "one",
        "kind": "hidden",
        "phenomena": list(hidden),
        "damper": "light_car",
        "excitation": "random",
        "unseen_excitation": "road",
        "wanted": 0.1,
        "verdict": verdict,
        "findings": [{"phenomenon": one, "effect": one, "tied_with": list(rest)} for one, *rest in named],
        "moved": [],
        "before": 50.0,
        "base": 10.0,
        "after": 10.0,
        "left": 9.0,
        "floor": 6.0,
        "force_rms": 500.0,
        "steps": [["start", None, None], ["add", "dahl", "friction"]],
        "improve_seconds": 30.0,
        "memory_mb": 300.0,
        "skew": 0.0,
        "true_skew": 0.0,
    } | more


def test_excess_is_fully_removed_if_the_error_equals_that_of_the_base():
    assert hidden_verdicts.removed(record(after=10.0)) == pytest.approx(1.0)
    assert hidden_verdicts.removed(record(after=50.0)) == 0.0
    assert hidden_verdicts.removed(record(after=60.0)) < 0.0


def test_without_an_excess_nothing_can_be_removed():
    assert isnan(hidden_verdicts.removed(record(before=10.0, base=10.0)))


def test_without_findings_the_verdict_is_in_first_place():
    changed = record(verdict="parameters_changed", named=[])
    assert hidden_verdicts.first_named(changed) == "parameters_changed"
    assert hidden_verdicts.first_group(changed) == set()
    assert hidden_verdicts.first_named(record(verdict="parameters_changed")) == "friction"


@pytest.mark.parametrize(
    ("groups", "found"),
    [
        ([{"friction"}, {"inertia"}], True),
        ([{"inertia", "current"}, {"blow_off"}, {"friction", "hysteresis"}], True),
        ([{"friction", "inertia"}], False),
        ([{"friction"}, {"blow_off"}], False),
        ([], False),
    ],
)
def test_two_effects_need_two_findings(groups, found):
    assert hidden_verdicts.both_found(groups, ("friction", "inertia")) is found
    assert hidden_verdicts.both_found(groups, ("inertia", "friction")) is found


def test_a_removed_effect_is_no_improvement():
    steps = [["start", None, None], ["add", "dahl", "friction"], ["add", "relief", "blow_off"], ["prune", "dahl", None]]
    assert hidden_verdicts.improved_by(record(steps=steps)) == [{"blow_off"}]


@pytest.mark.parametrize(
    ("skew", "group", "right"),
    [(2.2e-3, ["channel_skew"], True), (2.4e-3, ["channel_skew"], False), (2e-3, ["channel_skew", "friction"], False)],
)
def test_a_skew_must_be_right_and_alone(skew, group, right):
    one = record(("channel_skew",), [group], skew=skew, true_skew=2e-3)
    assert hidden_verdicts.skew_recovered(one) is right


def test_every_case_is_in_one_cell_of_the_matrix():
    cases = [
        record(),
        record(named=[("inertia", "friction")]),
        record(verdict="nothing_missing", named=[]),
        record(("inertia",), [("inertia",)]),
    ]
    rows = [line.split("|")[1:-1] for line in hidden_tables.confusion(cases).splitlines()[2:]]
    counts = {row[0].split()[1]: [int(cell.strip(" *") or 0) for cell in row[1:]] for row in rows}
    names = list(PHENOMENA)
    assert sum(map(sum, counts.values())) == len(cases)
    assert counts["friction"][names.index("friction")] == 1
    assert counts["friction"][names.index("inertia")] == 1
    assert counts["friction"][len(names)] == 1
    assert counts["inertia"][names.index("inertia")] == 1


def test_the_report_contains_every_figure_for_a_few_cases():
    cases = [
        record(),
        record(verdict="nothing_missing", named=[], steps=[["start", None, None]], after=50.0),
        record([], [("inertia",)], kind="nothing", diagnose_seconds=5.0),
        record(("friction", "inertia"), [("friction",), ("inertia",)], kind="pair"),
        record(("channel_skew",), [("channel_skew",)], kind="skew", skew=2.5e-3, true_skew=2e-3),
        {"name": "broken", "kind": "hidden", "failed": "ValueError: no"},
    ]
    text = hidden_tables.report(cases, 600.0, 2, 6)
    assert "| hidden effect in first place | – | 1 of 2 (50 %) | – | 1 of 2 (50 %) |" in text
    assert "false alarms, nothing hidden: 1 of 1 (100 %)" in text
    assert "both of two found by `diagnose`: 1 of 1 (100 %); added by `improve`: 0 of 1 (0 %)" in text
    assert "skew within 0.3 ms and not tied: 0 of 1 (0 %)" in text
    assert "failed: broken: ValueError: no" in text


def test_zero_and_drift_of_the_gauge_are_no_error():
    noise = np.random.default_rng(1).standard_normal(900)
    drifting = noise + np.linspace(3.0, -8.0, 900)
    assert np.allclose(hidden_cases.without_zero(drifting), hidden_cases.without_zero(noise))
    assert np.std(hidden_cases.without_zero(noise)) == pytest.approx(np.std(noise), rel=0.01)


def test_cases_have_unique_names_and_every_damper_has_every_excitation():
    plans = [*hidden_plans.nothing_plans(60), *hidden_plans.skew_plans(full=True), *hidden_plans.skew_plans(full=False)]
    names = {plan.name for plan in plans}
    assert len(names) == 60 + 60  # the shorter series of skews is a part of the longer one
    met = {(plan.damper, plan.fit, plan.unseen) for plan in hidden_plans.nothing_plans(24)}
    assert len(met) == len(hidden_plans.BENCHED) * len(hidden_plans.EXCITATIONS)


def test_base_fit_and_unseen_recording_are_different_drives_and_repeat_themselves():
    plan = hidden_plans.nothing_plans(1)[0]
    base, fit, unseen = plan.drives()
    assert not np.array_equal(base.displacement, fit.displacement)
    assert not np.array_equal(fit.displacement, unseen.displacement)
    assert np.array_equal(plan.drives()[0].displacement, base.displacement)


def test_two_hidden_effects_are_never_similar():
    assert all(first != second for first, second in hidden_plans.pairs())
    assert not any({"channel_skew", "mount_compliance"} == set(pair) for pair in hidden_plans.pairs())


@pytest.mark.parametrize("hidden", PHENOMENA)
def test_the_users_model_has_no_effect_of_the_hidden_phenomenon(hidden, monkeypatch):
    plan = hidden_plans.Plan("hidden", "light_car", "random", "random", 0.1, 1, (Calibration(hidden, 1.0, 0.1),))
    monkeypatch.setattr(hidden_cases, "fit", lambda model, data, starts: SimpleNamespace(model=model))
    monkeypatch.setattr(hidden_cases, "curve_knots", lambda base: [-1.0, 0.0, 1.0])
    model = hidden_cases.user_model(plan, plan.setup.damper, base=None)
    assert hidden not in {element.effect.phenomenon for element in model.effects}


def test_a_run_continues_only_with_verdicts_of_the_same_code(tmp_path):
    lines = [
        {"name": "kept", "judged_by": "now"},
        {"name": "old", "judged_by": "before"},
        {"name": "broken", "judged_by": "now", "failed": "ValueError: no"},
        {"name": "older"},
    ]
    place = tmp_path / "results.jsonl"
    place.write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert list(bench_hidden.kept_results(place, "now")) == ["kept"]
    assert bench_hidden.kept_results(tmp_path / "none.jsonl", "now") == {}


def test_the_balanced_bench_has_the_documented_cases():
    counts = {
        level: sum(bench_hidden._count(name, wanted) for name in PHENOMENA)
        for level, wanted in bench_hidden.LEVELS.items()
    }
    assert counts == {"medium": 72, "weak": 24, "strong": 24}


def test_a_saved_model_is_restored_from_its_text(tmp_path):
    model = load_model("carrera_akutain")
    with (tmp_path / "case").open("wb") as stream:
        hidden_cases._Pickler(stream).dump({"model": model})
    with (tmp_path / "case").open("rb") as stream:
        assert pickle.load(stream)["model"] == model
