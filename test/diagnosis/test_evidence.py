"""What the evidence says of where and when an effect takes error away."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis.attempt import null
from damper_estimator.diagnosis.evidence import confirming, evidence
from damper_estimator.diagnosis.judge import errors
from damper_estimator.diagnosis.scene import scene, targets
from damper_estimator.effects.discovery import find_effect
from damper_estimator.signals.layout import COMMAND, T, V


@pytest.fixture
def told(user_model, base):
    """Evidence where the share of the force that an effect takes away follows ``share`` (n,) over the recording, with a
    command (n,).
    """

    def told(share, command):
        block = base.kinematics.block.copy()
        block[COMMAND] = command(base)
        driven = replace(base, kinematics=replace(base.kinematics, block=block))
        own = null(user_model, scene(user_model, [driven], [driven]), base=())
        picks = own.scene.unseen[0].picks
        left = targets(own.scene.unseen) * np.sqrt(share(base)[picks])
        without, with_it = (errors(own.scene.blocks, own.residual_fit, one) for one in (left, 0.0 * left))
        return evidence(own, find_effect("coulomb"), without, with_it)

    return told


def elapsed(measurement):
    return measurement.kinematics.block[T] - measurement.kinematics.block[T, 0]


def test_what_grows_over_the_recording_is_said_so(told):
    text = told(lambda m: 0.1 + 0.01 * elapsed(m), lambda m: np.full(len(m.kinematics), 0.5))
    assert "grows with time" in text and "command" not in text


def test_a_command_that_hardly_ever_changes_is_not_what_it_grows_with(told):
    """It was higher in the first seconds, and the same ever since."""
    text = told(lambda m: 0.1 + 0.01 * elapsed(m), lambda m: np.where(elapsed(m) < 2.5, 0.8, 0.5))
    assert "grows with time" in text and "command" not in text.partition(", not with")[0].partition("falls")[0]


def test_what_follows_the_command_is_said_so(told):
    def command(measurement):
        return 0.5 + 0.4 * np.sin(elapsed(measurement) / 3.0)

    text = told(lambda m: 0.05 + 0.2 * command(m), command)
    assert "grows with command" in text


def test_the_speeds_that_lose_most_error_are_named(told):
    def fast_rebound(measurement):
        v = measurement.kinematics.block[V]
        return np.where(v > np.quantile(np.abs(v), 0.7), 0.3, 0.0)

    assert "lies in rebound between" in told(fast_rebound, lambda m: np.full(len(m.kinematics), 0.5))


def test_the_test_that_tells_look_alikes_apart_names_them():
    effect = find_effect("coulomb")
    assert confirming(effect, ["oil compressibility", "inertia"]).startswith(
        "To tell it from oil compressibility or inertia: "
    )
    assert confirming(effect, []).lower().startswith(effect.separate[:10].lower())
