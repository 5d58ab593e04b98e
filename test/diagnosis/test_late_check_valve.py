"""A check valve that closes steadily after each reversal, not with a time constant as that of the effect."""

import numpy as np
import pytest
from roads import road

import damper_estimator as de

RATE, SECONDS = 500.0, 30.0


def recording(name: str, seed: int, closing: float = 0.0, sides: tuple[float, ...] = (1.0, -1.0)) -> de.Recording:
    """A digressive damper on a road; its valves take ``closing`` seconds to shut, in these directions."""
    random, time = np.random.default_rng(seed), np.arange(round(RATE * SECONDS)) / RATE
    x = road(random, time, 12.0, size=4e-3, slope=1.8)
    v = np.gradient(x, time)
    lift = dict.fromkeys((1.0, -1.0), 0.0)
    through = v.copy()
    for i, speed in enumerate(v):
        for side in sides if closing else ():
            lift[side] = 1.0 if side * speed < 0.0 else max(lift[side] - 1.0 / (closing * RATE), 0.0)
            if side * speed > 0.0:
                through[i] = speed / (1.0 + 2.0 * lift[side])
    force = 900.0 * np.arctan(6.0 * through) + 500.0 * through
    return de.Recording.from_arrays(time, x, force=force + 2.0 * random.standard_normal(v.size), name=name)


@pytest.fixture(scope="module")
def model():
    """A user's model of the damper while its valves shut at once."""
    return de.fit(recording("base", 1), "viscous_curve").model


@pytest.mark.parametrize(("closing", "sides"), [(0.015, (1.0, -1.0)), (0.04, (1.0,))])
def test_valves_that_close_late_are_a_valve_delay_and_no_mount(closing, sides, model):
    fit, unseen = (recording(name, seed, closing, sides) for name, seed in (("fit", 2), ("unseen", 3)))
    found = de.diagnose(fit, model, validate=unseen).diagnosis.findings
    assert found[0].phenomenon == "valve_delay" and "mount_compliance" not in found[0].tied_with
    assert found[0].rmse_after_n < 0.5 * found[0].rmse_before_n


def test_valves_that_shut_at_once_are_not_blamed(model):
    assert not de.diagnose(recording("fit", 2), model, validate=recording("unseen", 3)).diagnosis.findings
