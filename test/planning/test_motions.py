"""Every motion obeys every limit, begins and ends at rest, and joins any other."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.planning import KINDS, Limits, acceleration_of, load_rig, motion, speed_of, steps_of

ROUNDING = 1.0 + 1e-6


@st.composite
def limits(draw):
    low = -draw(st.floats(0.002, 0.1))
    high = draw(st.floats(0.002, 0.1))
    top = draw(st.floats(2.0, 25.0))
    return Limits(
        low=low,
        high=high,
        home=draw(st.floats(0.8 * low, 0.8 * high)),
        speed=draw(st.floats(0.02, 2.0)),
        acceleration=draw(st.floats(0.5, 300.0)),
        force=1e4,
        frequency=(draw(st.floats(0.05, 1.0)), top),
        rate=draw(st.sampled_from([100.0, 200.0, 500.0, 1000.0])),
        mean_positions=draw(st.booleans()),
    )


@st.composite
def wanted(draw):
    low = draw(st.floats(0.1, 5.0))
    return {
        "frequency": low,
        "to": low * draw(st.floats(1.5, 4.0)),
        "amplitude": draw(st.floats(1e-4, 0.3)),
        "speed": draw(st.floats(0.005, 3.0)),
        "offset": draw(st.floats(-0.2, 0.2)),
        "seconds": draw(st.floats(1.0, 6.0)),
        "seed": float(draw(st.integers(0, 99))),
        "share": draw(st.floats(0.05, 1.0)),
    }


def obeys(x, bounds):
    """Whether samples stay inside displacement, speed and acceleration."""
    tiny = 1e-9
    return (
        bounds.low - tiny <= x.min()
        and x.max() <= bounds.high + tiny
        and np.abs(speed_of(x, bounds.rate)).max() <= ROUNDING * bounds.speed
        and np.abs(acceleration_of(x, bounds.rate)).max() <= ROUNDING * bounds.acceleration + 1e-6
    )


@pytest.mark.parametrize("kind", sorted(set(KINDS) - {"crank"}))
@settings(max_examples=60, deadline=None)
@given(bounds=limits(), values=wanted())
def test_every_motion_obeys_its_limits_from_rest_to_rest(kind, bounds, values):
    if kind == "triangle":
        values = values | {"amplitude": min(values["amplitude"], values["speed"] * 2.0)}
    x = motion(kind, values, bounds)
    assert np.isfinite(x).all()
    assert abs(x[0] - bounds.home) < 1e-12 and abs(x[-1] - bounds.home) < 1e-12
    assert obeys(np.concatenate([x, x]), bounds)


@settings(max_examples=20, deadline=None)
@given(bounds=limits(), data=st.data())
def test_every_step_of_a_rig_obeys_the_limits(bounds, data):
    rig = load_rig(data.draw(st.sampled_from(["servo_hydraulic", "four_post", "track"])))
    for step in steps_of(rig, bounds, currents=False, temperatures=False):
        assert obeys(step.displacement, bounds), step.words
        if step.kind == "sine":
            assert bounds.frequency[0] <= step.values["frequency"] <= bounds.frequency[1]


def test_a_crank_has_one_amplitude():
    rig = load_rig("crank")
    bounds = Limits(-0.025, 0.025, 0.0, 1.0, 80.0, 1e4, (0.1, 8.0), 1000.0, amplitude=0.025)
    steps = steps_of(rig, bounds, currents=False, temperatures=False)
    assert len(steps) > 3
    for step in steps:
        assert step.kind == "crank" and obeys(step.displacement, bounds)
        assert np.abs(step.displacement).max() == pytest.approx(0.025, rel=0.02)


def test_levels_of_current_and_temperature_multiply_the_steps():
    rig = load_rig("crank")
    bounds = Limits(
        -0.025, 0.025, 0.0, 1.0, 80.0, 1e4, (0.1, 8.0), 1000.0, amplitude=0.025, temperature=(20.0, 60.0),
        current=(0.0, 1.0, 2.0),
    )  # fmt: skip
    plain, all_ = (steps_of(rig, bounds, currents=both, temperatures=both) for both in (False, True))
    assert len(all_) == 6 * len(plain)
    assert any("at 2 A" in step.words and "at 60 deg C" in step.words for step in all_)


@settings(max_examples=20, deadline=None)
@given(bounds=limits(), values=wanted())
def test_a_multisine_reaches_what_it_may(bounds, values):
    x = motion("multisine", values | {"offset": 0.0}, bounds) - bounds.home
    reached = max(
        np.abs(x / np.where(x < 0.0, bounds.low - bounds.home, bounds.high - bounds.home)).max(),
        np.abs(speed_of(x, bounds.rate)).max() / bounds.speed,
        np.abs(acceleration_of(x, bounds.rate)).max() / bounds.acceleration,
    )
    assert 0.95 * values["share"] <= reached <= 1.001 * values["share"]


def test_the_peaks_of_a_multisine_are_low():
    """Random phases have a crest factor of about four."""
    bounds = Limits(-0.05, 0.05, 0.0, 0.6, 200.0, 1e4, (0.1, 24.0), 1000.0)
    for seed in range(5):
        values = {"frequency": 0.3, "to": 24.0, "seconds": 10.0, "share": 1.0, "seed": float(seed)}
        speed = speed_of(motion("multisine", values, bounds), bounds.rate)
        assert np.abs(speed).max() < 2.8 * speed.std()


def test_random_motion_is_another_one_each_time():
    steps = steps_of(load_rig("servo_hydraulic"), Limits(-0.05, 0.05, 0.0, 0.6, 200.0, 1e4, (0.1, 24.0), 1000.0), False,
                     False)  # fmt: skip
    for step in steps:
        again = step.repeated(1)
        assert again.displacement.shape == step.displacement.shape
        assert np.array_equal(again.displacement, step.displacement) != step.is_random
        assert step.repeated(0) is step
