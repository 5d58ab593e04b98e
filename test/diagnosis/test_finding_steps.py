"""Findings put into the model: of two, both stay only where the second one is worth it."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from faults import changed
from planted import rounded, tried

from damper_estimator.diagnosis.accepted import accepted_in, regions_of
from damper_estimator.diagnosis.apply_finding import ModelState, state_of
from damper_estimator.diagnosis.steps import steps_of
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element

BEFORE = 10.0  # N, without either


def delivered(noisy, monkeypatch, errors: dict[tuple[str, ...], float], promised: dict[str, float]) -> list[str]:
    """Effects that become steps, first to last.

    Args:
        errors: unseen error in N with effects in the model.
        promised: by the search, in N^2, by effect.
    """
    one, other = promised
    current = rounded(noisy, tried(noisy, one, 0.9), tried(noisy, other, 0.8))
    pair = [accepted_in(current, hypothesis) for hypothesis in current.hypotheses]
    names = {one: other, other: one}
    partners = {accepted.element.effect.name: accepted.element.effect.phenomenon for accepted in pair}
    pair = [
        replace(
            accepted,
            partner=partners[names[accepted.element.effect.name]],
            before_n=BEFORE,
            after_n=(BEFORE**2 - promised[accepted.element.effect.name]) ** 0.5,
        )
        for accepted in pair
    ]

    def applied(before, accepted, mode, promise):
        added = tuple(sorted({*before.added, accepted.element.effect.name}))
        return replace(before, added=added, rmse_unseen_n=errors[added])

    monkeypatch.setattr(import_module("damper_estimator.diagnosis.steps"), "_applied", applied)
    start = ModelState(noisy.model, (), (), (), (), BEFORE, BEFORE)
    return regions_of([step[0] for step in steps_of(start, pair, "both")])


@pytest.mark.parametrize(
    "alone, both, idle, kept",
    [
        ((7.0, 6.0), 2.0, (), {"coulomb", "inertia"}),
        ((7.0, 4.0), 2.0, ("coulomb",), {"inertia"}),  # whatever the other one promised
        ((7.0, 4.0), 2.0, ("coulomb", "inertia"), set()),  # it was the parameters of the model
        ((7.0, 4.0), 4.5, (), {"inertia"}),  # the other one does harm
        ((4.0, 4.0), 4.0, (), {"coulomb"}),  # either will do: the one that promised more
        ((9.9, 9.8), 2.0, (), {"coulomb", "inertia"}),  # they act against each other
    ],
)
def test_both_effects_of_a_pair_are_kept_only_if_both_have_a_part_in_it(alone, both, idle, kept, noisy, monkeypatch):
    module = import_module("damper_estimator.diagnosis.steps")
    monkeypatch.setattr(module, "_is_idle", lambda one, before, after: one.element.effect.name in idle)
    errors = {("coulomb",): alone[0], ("inertia",): alone[1], ("coulomb", "inertia"): both}
    assert set(delivered(noisy, monkeypatch, errors, {"coulomb": 70.0, "inertia": 40.0})) == kept


def test_a_name_for_changed_parameters_has_to_lower_the_error_too(noisy, monkeypatch):
    current = rounded(noisy, tried(noisy, "coulomb", 0.9), tried(noisy, "inertia", 0.8))
    falling, rising = (
        replace(accepted_in(current, hypothesis), before_n=BEFORE, after_n=after)
        for hypothesis, after in zip(current.hypotheses, (4.0, 12.0), strict=True)
    )
    monkeypatch.setattr(import_module("damper_estimator.diagnosis.steps"), "_applied", lambda before, *_: before)
    start = ModelState(noisy.model, (), (), (), (), BEFORE, BEFORE)
    steps = steps_of(start, [falling, rising], "both", names_changes=True)
    assert [(one, before, after) for one, _, before, after in steps] == [(falling, BEFORE, 4.0)]


@pytest.mark.parametrize("friction, is_idle", [(0.0, True), (120.0, False)])
def test_an_effect_that_is_not_missed_where_it_is_taken_out_again_is_idle(user_model, base, friction, is_idle, noisy):
    """The model without it errs as much: what lowered the error was something else."""
    module = import_module("damper_estimator.diagnosis.steps")
    recording = changed(base, lambda k: 120.0 * np.sign(k.velocity))
    before = state_of(user_model, [recording], [recording])
    added = make_element(find_effect("coulomb"), {"force": friction})
    after = replace(before.with_model(user_model.with_missing(added)), added=("coulomb",))
    current = rounded(noisy, tried(noisy, "coulomb", 0.9))
    one = accepted_in(current, current.best)
    if not friction:  # parameters of the model have lowered the error
        before = replace(before, rmse_unseen_n=2.0 * before.rmse_unseen_n)
    assert module._is_idle(one, before, after) == is_idle
