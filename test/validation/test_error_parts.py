"""The parts of the error: zero, drift, gain and scatter, none mistaken for another."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.validation import compare

TRUE = 1500.0  # N s/m, of the model


def parts_of(viscous, measurement):
    return compare(viscous, measurement).split


def with_(more):
    return lambda k: TRUE * k.velocity + more(k)


@pytest.mark.parametrize("zero", [35.0, -35.0])
def test_an_offset_is_the_zero_and_no_region(zero, viscous, motion, measured):
    c = compare(viscous, measured(*motion(), with_(lambda k: zero + 0.0 * k.time)))
    assert c.split.offset_n == pytest.approx(-zero, abs=1e-6) and c.regions == ()
    assert f"35 N {'high' if zero > 0 else 'low'} throughout" in c.split.sentences[0]


def test_a_drift_is_reported_with_its_time_and_is_no_region(viscous, motion, measured):
    c = compare(viscous, measured(*motion(), with_(lambda k: 40.0 * np.clip(k.time - 10.0, 0.0, 20.0) / 20.0)))
    assert c.split.drift_n == pytest.approx(np.std(np.clip(np.linspace(-10, 30, 1000), 0.0, 20.0) * 2.0), rel=0.05)
    assert c.regions == () and any("drifts against the model's by +4" in text for text in c.split.sentences)


@pytest.mark.parametrize("gain", [0.8, 1.25])
def test_a_gain_is_reported_in_percent(gain, viscous, motion, measured):
    parts = parts_of(viscous, measured(*motion(), lambda k: gain * TRUE * k.velocity))
    assert parts.gain == pytest.approx(1.0 / gain - 1.0, rel=1e-6) and parts.scatter_n < 1e-6
    assert f"{100 * abs(1 / gain - 1):.2g} % too {'large' if gain < 1 else 'small'} as a whole" in parts.sentences[0]


def test_what_is_called_a_zero_lowers_the_error(viscous, motion, measured):
    """Slow motion is off by a constant that the fast motion makes up for: no constant corrects that."""

    def error(k):
        slow = np.exp(-((k.velocity / 0.1) ** 2))
        return 40.0 * (slow - np.mean(slow))

    c = compare(viscous, measured(*motion(), with_(error)))
    assert abs(c.measures.bias_n) < 1.0
    assert c.split.offset_n == 0.0 and not any("standstill" in text for text in c.split.sentences)


ERRORS = {
    "one direction": lambda k: 800.0 * np.maximum(k.velocity, 0.0),
    "asymmetry": lambda k: 600.0 * np.abs(k.velocity),
    "one place": lambda k: 150.0 * (k.displacement > 0.01),
    "a spring": lambda k: 4000.0 * k.displacement,
    "friction": lambda k: 60.0 * np.tanh(k.velocity / 0.005),
    "inertia": lambda k: 2.0 * k.acceleration,
    "the second half": lambda k: 150.0 * np.sign(k.velocity) * (k.time > 20.0),
}


@pytest.mark.parametrize("error", ERRORS.values(), ids=ERRORS)
def test_an_error_of_the_operation_is_neither_zero_nor_drift_nor_gain(error, viscous, motion, measured):
    parts = parts_of(viscous, measured(*motion(), with_(error)))
    assert parts.offset_n == 0.0 and parts.drift_n == 0.0
    assert not any("as a whole" in text or "standstill" in text for text in parts.sentences)


def test_friction_is_reported_as_the_same_against_every_motion(viscous, motion, measured):
    parts = parts_of(viscous, measured(*motion(), with_(ERRORS["friction"])))
    assert len(parts.sentences) == 1 and "N too soft both ways, whatever the speed" in parts.sentences[0]


def test_zeros_of_recordings_are_reported_one_by_one(viscous, motion, measured):
    one, other = (
        measured(*motion(seed=i), with_(lambda k, z=z: z + 0.0 * k.time)) for i, z in enumerate((50.0, -20.0))
    )
    parts = compare(viscous, replace(one, recording="a.mcap"), replace(other, recording="b.mcap")).split
    assert parts.offsets == pytest.approx((-50.0, 20.0), abs=1e-6) and parts.offset_n == pytest.approx(-15.0, abs=1e-6)
    assert "50 N high in a.mcap" in parts.sentences[0] and "20 N low in b.mcap" in parts.sentences[0]


def test_the_parts_add_up(viscous, motion, measured):
    """The squares of parts that have nothing to do with each other add up to the error's."""
    draw = np.random.default_rng(0)
    parts = with_(lambda k: 30.0 + 0.2 * TRUE * k.velocity + 15.0 * draw.standard_normal(len(k)))
    c = compare(viscous, measured(*motion(), parts))
    parts = c.split
    total = parts.offset_n**2 + parts.drift_n**2 + parts.gain_n**2 + parts.scatter_n**2
    assert total == pytest.approx(c.measures.rmse_n**2, rel=0.03)
    assert parts.offset_n == pytest.approx(-30.0, abs=4.0) and parts.gain == pytest.approx(-1.0 / 6.0, rel=0.05)


def test_noise_alone_is_scatter(viscous, motion, measured):
    draw = np.random.default_rng(1)
    parts = parts_of(viscous, measured(*motion(), with_(lambda k: 30.0 * draw.standard_normal(len(k)))))
    assert parts.sentences == () and parts.offset_n == parts.drift_n == 0.0


def test_the_record_tells_the_parts(viscous, motion, measured):
    record = compare(viscous, measured(*motion(), with_(lambda k: 35.0 + 0.0 * k.time))).record()
    assert {"offset_n", "drift_n", "gain", "gain_n", "scatter_n", "sentences"} <= set(record)
