"""Desired forces of a semi-active damper, and the body's velocity that the laws need."""

import numpy as np
import pytest

from damper_estimator.control import BodyVelocity, groundhook, mixed, passive, skyhook


def test_each_law_damps_its_mass():
    assert skyhook(2000.0).force(0.3, 5.0) == pytest.approx(600.0)
    assert groundhook(2000.0).force(0.3, 5.0) == pytest.approx(-10000.0)
    assert passive(2000.0).force(0.3, 0.1) == pytest.approx(400.0)


def test_mixed_goes_from_groundhook_to_skyhook():
    for law, share in ((groundhook, 0.0), (skyhook, 1.0)):
        assert mixed(1500.0, share).force(0.4, -0.7) == pytest.approx(law(1500.0).force(0.4, -0.7))
    with pytest.raises(ValueError, match="share 1.2"):
        mixed(1500.0, 1.2)


@pytest.mark.parametrize("law", [skyhook(3000.0), mixed(3000.0, 0.5), passive(3000.0)])
def test_a_car_comes_to_rest_by_the_law_alone(law):
    """With an ideal actuator; a groundhook alone would not damp the body."""
    body, wheel, spring, tyre = 300.0, 40.0, 20000.0, 200000.0
    z, w, vz, vw, dt, energies = 0.02, 0.01, 0.3, -0.4, 1e-4, []
    for _ in range(20000):
        force = law.force(vz, vw) + spring * (z - w)
        vz -= dt * force / body
        vw += dt * (force - tyre * w) / wheel
        z, w = z + dt * vz, w + dt * vw
        energies.append(0.5 * (body * vz**2 + wheel * vw**2 + spring * (z - w) ** 2 + tyre * w**2))
    assert energies[-1] < 0.05 * energies[0]


def test_the_bodys_velocity_follows_its_acceleration_and_removes_an_offset():
    time = np.arange(0.0, 60.0, 0.002)
    velocity = 0.2 * np.sin(2.0 * np.pi * 1.3 * time)
    felt = np.gradient(velocity, time) + 0.05
    estimate, body = np.empty(time.size), BodyVelocity()
    for k, acceleration in enumerate(felt):
        estimate[k] = body.step(acceleration, 0.002 if k else 0.0)
    late = time > 40.0
    assert abs(estimate[late].mean()) < 1e-3
    assert np.sqrt(np.mean((estimate - velocity)[late] ** 2)) < 0.25 * velocity.std()
    assert estimate[late].std() == pytest.approx(velocity.std(), rel=0.03)


def test_a_step_of_zero_resets_the_bodys_velocity():
    body, fresh = BodyVelocity(), BodyVelocity()
    for k in range(50):
        body.step(1.0, 0.002 * (k > 0))
    assert body.step(0.5, 0.0) == 0.0 == fresh.step(0.5, 0.0)
    assert body.step(0.5, 0.01) == fresh.step(0.5, 0.01) > 0.0
