"""The population's figures are correct, and its runs survive any failure of a case."""

from math import isnan, sqrt

import numpy as np
import pytest
from population import ablated_models, case_processes, result_tables, saved_cases, scoring, user_models
from population.cases import Card
from population.measurement_chain import Chain, Samples

import damper_estimator as de
from damper_estimator.model import load_model


def record(hidden=("friction",), named=(("friction",),), verdict="missing", confidence=0.9, **more):
    """A record like a line of the results; ``named`` is the group of each finding, its phenomenon first."""
    return {
        "name": "one",
        "kind": "hidden" if hidden else "nothing",
        "hidden": list(hidden),
        "level": "medium",
        "against": False,
        "forms": ["a form"],
        "family": "monotube",
        "drive": ["road", "random"],
        "rate": 500,
        "seconds": 60.0,
        "model": "fit viscous_curve",
        "strengths": [0.1],
        "shown": 0.1,
        "verdict": verdict,
        "findings": [
            {"phenomenon": one, "effect": one, "confidence": confidence, "tied_with": list(rest)}
            for one, *rest in named
        ],
        "moved": [],
        "before": 50.0,
        "base": 10.0,
        "own_base": 9.0,
        "after": 10.0,
        "bias": 1.0,
        "force_rms": 500.0,
        "steps": [["start", None, None], ["add", "dahl", "friction"]],
        "skew": 0.0,
        "true_skew": 0.0,
        "diagnose_seconds": 5.0,
        "improve_seconds": 15.0,
        "all_cpu": 40.0,
    } | more


@pytest.mark.parametrize(
    ("named", "verdict", "first", "tied", "renamed"),
    [
        ((("friction",),), "missing", True, True, False),
        ((("friction", "hysteresis"),), "missing", True, True, False),
        ((("hysteresis", "friction"),), "missing", False, True, False),
        ((("hysteresis",), ("friction",)), "missing", False, False, True),
        ((("friction",),), "parameters_changed", True, True, False),
        ((), "nothing_missing", False, False, False),
    ],
)
def test_places_of_the_hidden_effect(named, verdict, first, tied, renamed):
    case = record(named=named, verdict=verdict)
    assert (scoring.first(case), scoring.tied(case), scoring.renamed(case)) == (first, tied, renamed)


@pytest.mark.parametrize("verdict", ("missing", "parameters_changed", "unexplained"))
def test_any_finding_with_nothing_hidden_is_an_alarm(verdict):
    assert scoring.alarm(record(hidden=(), verdict=verdict))
    assert not scoring.alarm(record(hidden=(), verdict="nothing_missing", named=()))


def test_a_finding_that_removes_most_of_the_squared_error_is_what_the_model_lacks():
    found = [record(hidden=(), found_error=newtons) for newtons in (20.0, 30.0, 40.0)]
    assert [scoring.explained(one) for one in found] == [True, True, False]
    text = result_tables.summary(found)
    assert "an effect named, nothing hidden: 3 of 3" in text
    assert "leaves more than half of the squared error on unseen recordings: 1 of 3" in text


@pytest.mark.parametrize(
    ("named", "both"),
    [
        ((("friction",), ("inertia",)), True),
        ((("hysteresis", "friction"), ("channel_skew", "inertia")), True),
        ((("friction", "inertia"),), False),
        ((("friction",),), False),
    ],
)
def test_two_effects_need_two_findings(named, both):
    assert scoring.both(record(hidden=("friction", "inertia"), named=named)) is both


def test_a_removed_effect_does_not_count_as_added():
    steps = [["start", None, None], ["add", "dahl", "friction"], ["add", "inertia", "inertia"], ["prune", "dahl", None]]
    assert not scoring.both_added(record(hidden=("friction", "inertia"), steps=steps))
    assert scoring.both_added(record(hidden=("friction", "inertia"), steps=steps[:3]))


@pytest.mark.parametrize(
    ("named", "skew", "found"),
    [
        ((("channel_skew",),), 0.00225, True),
        ((("channel_skew",),), 0.0024, False),
        ((("inertia", "channel_skew"),), 0.0, True),
        ((("inertia",),), 0.002, False),
        ((), 0.002, False),
    ],
)
def test_a_skew_must_be_right_or_tied(named, skew, found):
    assert scoring.skew_found(record(named=named, skew=skew, true_skew=0.002)) is found


def test_excess_is_fully_removed_if_the_error_equals_that_without_the_effect():
    assert scoring.removed(record(after=10.0)) == pytest.approx(1.0)
    assert scoring.removed(record(after=50.0)) == 0.0
    assert isnan(scoring.removed(record(before=10.0)))


@pytest.mark.parametrize(("hits", "count"), [(0, 7), (3, 11), (9, 10), (20, 20)])
def test_at_the_ends_of_an_interval_the_share_is_just_likely(hits, count):
    share = hits / count
    for end in scoring.wilson(hits, count):
        if 0.0 < end < 1.0:
            assert abs(share - end) == pytest.approx(scoring.Z * sqrt(end * (1.0 - end) / count))


def test_a_bootstrap_ignores_non_finite_values_and_contains_its_figure():
    values = [0.8, 0.9, 1.0, float("nan")]
    middle, low, high = scoring.bootstrap(values, np.median)
    assert middle == 0.9
    assert 0.8 <= low <= middle <= high <= 1.0
    assert all(isnan(value) for value in scoring.bootstrap([float("nan")], np.median))


def test_confidence_equal_to_the_share_of_right_findings_has_no_calibration_error():
    right = [record(confidence=0.75)] * 3 + [record(confidence=0.75, named=(("inertia",),))]
    rows, gap = scoring.calibration(right)
    assert rows == [(0.75, 0.75, 4)]
    assert gap == pytest.approx(0.0)
    rows, gap = scoring.calibration([record(confidence=1.0, hidden=()), record(confidence=1.0)])
    assert gap == pytest.approx(0.5)


def test_the_report_contains_every_section_and_every_failure():
    records = [
        record(),
        record(named=(("inertia",),)),
        record(hidden=("friction", "inertia"), kind="pair", named=(("friction",), ("inertia",))),
        record(hidden=()),
        {"name": "broken", "kind": "hidden", "hidden": ["friction"], "level": "weak", "failed": "ValueError: no"},
    ]
    text = result_tables.report(records, [7])
    for part in ("seed 7", "broken: ValueError: no", "1 of 2: 50 %", "friction + inertia", "calibration error"):
        assert part in text
    assert all("FAILED" in result_tables.line(one) or "N" in result_tables.line(one) for one in records)


def test_a_saved_case_is_restored(tmp_path):
    time = np.arange(50) / 100.0
    one = Samples("fit", time, 0.01 * np.sin(time), 100.0 * time, None, np.ones(50), 99.0 * time)
    recordings = dict.fromkeys(saved_cases.RECORDINGS, (one, one))
    kept = saved_cases.Kept({"name": "a"}, Chain(100, 0, 0, 0, 0, 0, 0), recordings, load_model("viscous_curve"))
    saved_cases.save(tmp_path, "a", kept)
    again = saved_cases.saved(tmp_path, "a")
    assert again.facts == kept.facts
    assert again.chain == kept.chain
    assert len(again.recordings["fit"]) == 2
    samples = again.recordings["fit"][1]
    assert samples.time == pytest.approx(time)
    assert samples.x == pytest.approx(one.x, rel=1e-6)
    assert samples.temperature is None
    assert saved_cases.saved(tmp_path, "b") is None


def test_a_case_that_breaks_or_never_ends_is_a_failure_of_that_case_alone(tmp_path):
    place = tmp_path / "results.jsonl"
    cards = [Card(0, "hidden", ("no such phenomenon",), "medium")]
    order = case_processes.Order(1, tmp_path, improving=False, limit=120.0)
    (broken,) = case_processes.results(cards, order, 1, place)
    assert "no such phenomenon" in broken["failed"]
    assert "Traceback" in broken["traceback"]
    (late,) = case_processes.results(cards, case_processes.Order(1, tmp_path, False, 0.01), 1, place)
    assert "longer" in late["failed"]
    assert len(place.read_text().splitlines()) == 2
    assert case_processes.done(place) == {}


def test_a_run_continues_after_a_truncated_line(tmp_path):
    place = tmp_path / "results.jsonl"
    place.write_text('{"name": "a", "verdict": "missing"}\n{"name": "b", "ver')
    assert list(case_processes.done(place)) == ["a"]


def test_a_model_is_rough_if_its_error_exceeds_the_hidden_change():
    assert not scoring.rough(record(base=49.0, shown=0.1, strengths=[0.1], force_rms=500.0))
    assert scoring.rough(record(base=51.0, shown=0.1, strengths=[0.1], force_rms=500.0))
    # Opposite effects can cancel nearly completely.
    assert not scoring.rough(record(base=49.0, shown=0.02, strengths=[0.1, 0.1], force_rms=500.0))
    assert not scoring.rough(record(hidden=(), base=51.0, shown=0.0, strengths=[]))


def test_an_effect_that_matters_is_removed_from_the_best_model():
    time = np.arange(4000) / 200.0
    x = 0.01 * np.sin(2.0 * np.pi * 1.5 * time) + 0.006 * np.sin(2.0 * np.pi * 4.0 * time)
    v = np.gradient(x, time)
    force = 900.0 * v + 120.0 * np.tanh(v / 0.005)
    measured = user_models.recording([Samples("one", time, x, force, None, None, force)], de.SignalMap())
    ranking = ablated_models.ranked(measured, measured, ("dahl", "linear_viscous"))
    less = ablated_models.ablated(ranking, measured, measured, np.random.default_rng(0))
    assert ranking[0][1].name == "dahl"
    assert (less.effect, less.phenomenon) == ("dahl", "friction")
    assert less.error == ranking[0][0] < user_models.error(less.model, measured)
    with pytest.raises(ablated_models.NothingMatters):
        ablated_models.ablated(ranking[1:], measured, measured, np.random.default_rng(0))
