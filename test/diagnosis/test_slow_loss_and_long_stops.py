"""What real dampers have in forms that are less sharp than those of a text book: the shipped recording, changed."""

import numpy as np
import pytest

import damper_estimator as de


@pytest.fixture(scope="module")
def halves(base):
    """Diagnoses a change of the force in both halves of the shipped recording, with a model that was identified on the
    first half; ``strong`` times as much force without and with it.
    """
    k = base.kinematics
    half = k.time.size // 2

    def recorded(part: slice, strong: float, change=lambda t, x, force: force) -> de.Recording:
        t, x = k.time[part] - k.time[part][0], k.displacement[part]
        return de.Recording.from_arrays(t, x, force=change(t, x, strong * base.force[part]))

    def diagnosed(change, strong: float = 1.0):
        first, second = slice(0, half), slice(half, None)
        model = de.fit(recorded(first, strong), "viscous_curve").model
        fit, unseen = recorded(first, strong, change), recorded(second, strong, change)
        return de.diagnose(fit, model, validate=unseen).diagnosis

    return diagnosed


def test_a_foam_bump_stop_that_touches_before_the_middle_is_a_stop(halves, base):
    low, high = np.quantile(base.kinematics.displacement, [0.001, 0.999])
    touch = low + 0.58 * (high - low)

    def stopped(t, x, force):
        return force - 900.0 * (np.maximum(touch - x, 0.0) / (touch - low)) ** 2.6

    found = halves(stopped)
    first = found.findings[0]
    assert first.phenomenon == "end_stop", found.sentence
    assert first.rmse_after_n < 0.5 * first.rmse_before_n


def test_a_force_that_falls_with_time_is_temperature_although_none_is_measured(halves):
    found = halves(lambda t, x, force: force * (1.0 - 0.025 * t))
    names = {name for one in found.findings[:1] for name in (one.phenomenon, *one.tied_with)}
    assert "temperature_fade" in names, found.sentence
    assert "temperature_fade" not in {one.phenomenon for one in halves(lambda t, x, force: force).findings}


def test_a_heavy_fixture_in_front_of_a_strong_damper_is_a_mass(halves):
    def with_mass(t, x, force):
        return force + 120.0 * np.gradient(np.gradient(x, t), t)

    first = halves(with_mass, strong=10.0).findings[0]
    assert (first.phenomenon, first.effect) == ("inertia", "inertia")
    assert first.parameters[0].value == pytest.approx(120.0, rel=0.05)
