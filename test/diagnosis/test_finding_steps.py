"""Findings put into the model: of two, both stay only where the second one is worth it."""

from dataclasses import replace
from importlib import import_module

import pytest
from planted import rounded, tried

from damper_estimator.diagnosis.accepted import accepted_in, names_of
from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.steps import steps_of

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
    return names_of([step[0] for step in steps_of(start, pair, "both")])


@pytest.mark.parametrize(
    "alone, both, kept",
    [
        ((7.0, 6.0), 2.0, {"coulomb", "inertia"}),
        ((7.0, 4.0), 3.9, {"inertia"}),  # the other one adds next to nothing, whatever it promised
        ((7.0, 4.0), 4.5, {"inertia"}),  # the other one does harm
        ((4.1, 4.0), 3.9, {"coulomb"}),  # either will do: the one that promised more
        ((9.9, 9.8), 2.0, {"coulomb", "inertia"}),  # they act against each other
    ],
)
def test_both_effects_of_a_pair_are_kept_only_if_each_adds_what_a_second_finding_must(
    alone, both, kept, noisy, monkeypatch
):
    errors = {("coulomb",): alone[0], ("inertia",): alone[1], ("coulomb", "inertia"): both}
    assert set(delivered(noisy, monkeypatch, errors, {"coulomb": 70.0, "inertia": 40.0})) == kept
