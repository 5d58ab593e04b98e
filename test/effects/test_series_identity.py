"""A compliance claims only what is its own: a pocket lies in one chamber, and a mount is no dashpot."""

import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges

RANGES = Ranges(-0.03, 0.03, speed=0.5, acceleration=20.0, force=500.0, seconds=20.0)


def exclusion(name, **values):
    return find_effect(name).trial(RANGES).exclusion(values)


@pytest.mark.parametrize(("rebound", "compression", "reason"), [
    (5000.0, 900.0, ""),
    (900.0, 5000.0, ""),
    (900.0, 1000.0, "alike in both directions"),
    (1000.0, 900.0, "alike in both directions"),
    (2000.0, 2500.0, "hardly becomes softer"),
])  # fmt: skip
def test_a_pocket_limits_one_direction(rebound, compression, reason):
    said = exclusion("gas_pocket", stiffness=1e6, limit_rebound=rebound, limit_compression=compression)
    assert reason in said and bool(reason) == bool(said)


@pytest.mark.parametrize(("tangent", "lasts"), [(0.1, True), (0.5, True), (0.9, True), (1.2, False), (3.0, False)])
@pytest.mark.parametrize("stiffness", [2e5, 5e6])
def test_a_mount_stores_more_than_it_loses(tangent, lasts, stiffness):
    loss = tangent * stiffness / (2.0 * 3.14159265 * 10.0)
    assert lasts == (not exclusion("rubber_mount", stiffness=stiffness, loss=loss))
