"""Models with compliances start from what is found with the compliances rigid."""

import numpy as np
import pytest

from damper_estimator.identification import LocalRows, Problem, fit, rows_of
from damper_estimator.identification.methods.least_squares import best_start, released
from damper_estimator.identification.rigid import FACTORS, common_slots, with_rigid_starts, without_compliances
from damper_estimator.identification.rows import excerpts
from damper_estimator.identification.start_points import candidates
from damper_estimator.model import load_model, parse_model
from damper_estimator.signals.layout import COMMAND

CURVE = {"velocity": [-0.6, -0.2, 0.0, 0.2, 0.6], "force": [-900.0, -600.0, 0.0, 400.0, 700.0]}
FLAT = {**CURVE, "force": [0.0] * 5}


def behind_oil(curve, stiffness):
    oil = {"stiffness_rebound": stiffness, "stiffness_compression": stiffness, "path": [{"viscous_curve": curve}]}
    return parse_model({"name": "oil", "effects": [{"oil_spring": oil}]}, "oil")


def test_what_a_compliance_carries_stays_in_its_place():
    model = load_model("spencer")
    rigid = without_compliances(model)
    assert "dashpot" not in rigid.uses() and "scaled" not in rigid.uses()
    for slot, place in zip(rigid.slots, common_slots(model, rigid), strict=True):
        there = model.slots[place]
        assert (there.parameter, there.index, there.value) == (slot.parameter, slot.index, slot.value)
    passive = load_model("viscous_curve")
    assert without_compliances(passive) is passive


def test_a_start_holds_the_curve_that_is_found_without_the_compliance(measured):
    recorded = measured(behind_oil(CURVE, 4e6), rms=0.02)
    model = behind_oil(FLAT, 1e6)
    problem = Problem(model, LocalRows([rows_of(recorded)]), range(len(model.slots)))
    given, _ = candidates(problem, 0)
    starts = with_rigid_starts(problem, problem, given, 0, best_start)
    np.testing.assert_array_equal(starts[0], given[0])
    assert len(starts) == len(given) + len(FACTORS)
    addresses = [problem.slots[i].address for i in problem.searched]
    found = dict(zip(addresses, starts[1], strict=True))
    assert found["oil_spring.stiffness_rebound"] == 1e6
    assert [found[f"viscous_curve.force[{k}]"] for k in range(5)] == pytest.approx(CURVE["force"], abs=60.0)


def test_a_curve_behind_oil_is_found_from_a_flat_one(measured):
    recorded = measured(behind_oil(CURVE, 2e6), rms=0.02)
    start = {**CURVE, "force": [-1.0, -1.0, 0.0, 1.0, 1.0]}
    result = fit(behind_oil(start, 1e7), [recorded])
    found = {p.name: p.value for p in result.parameters}
    assert result.esr < 1e-4
    assert [found[f"viscous_curve.force[{k}]"] for k in range(5)] == pytest.approx(CURVE["force"], rel=0.05, abs=10.0)
    assert found["oil_spring.stiffness_rebound"] == pytest.approx(2e6, rel=0.1)


def test_an_excerpt_shows_a_step_of_the_command_where_there_is_one(measured):
    command = np.where(np.arange(4000) < 3000, 0.2, 1.4)
    recorded = measured(load_model("semi_active_yield"), command=command)
    (part,) = excerpts(recorded, 800)
    assert np.ptp(recorded.kinematics.block[COMMAND, part]) > 1.0


def test_a_lag_at_its_bound_returns_to_the_models_value(measured):
    """At the bound it has no derivative, so that a search stays there."""
    model = load_model("semi_active_yield")
    recorded = measured(model, rms=0.03, command=np.repeat([0.2, 1.5, 0.6, 1.9, 0.0, 1.2, 0.3, 1.8], 500))
    problem = Problem(model, LocalRows([rows_of(recorded)]), range(len(model.slots)))
    (lag,) = [k for k, i in enumerate(problem.searched) if problem.slots[i].address == "command_yield.time_constant"]
    ended = problem.start.copy()
    ended[lag] = problem.lower[problem.searched[lag]]
    np.testing.assert_array_equal(released(problem, ended, problem.start), problem.start)


def test_an_excerpt_shows_what_is_of_interest_however_rare(measured):
    recorded = measured(load_model("semi_active_yield"), command=np.full(4000, 0.5))
    for at in (100, 1700, 3900):
        interest = np.zeros(4000)
        interest[at : at + 20] = 1.0
        (part,) = excerpts(recorded, 800, interest=interest)
        assert part.start <= at < part.stop
    assert excerpts(recorded, 800, interest=np.ones(4000)) == excerpts(recorded, 800)
