"""Every phenomenon can be switched, grows with its magnitude, and can be set to a wanted strength."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.plant import (
    DAMPERS,
    PHENOMENA,
    Drive,
    Sensors,
    Setup,
    bench_drive,
    calibrate,
    current_steps,
    hidden,
    relative_difference,
    simulate,
    strength,
    switched,
    without,
)
from damper_estimator.plant.calibration import in_band

STEP = 2e-4
SETUP = Setup(DAMPERS["passenger_front"], Sensors())
CHAIN = {"channel_skew", "spring_rate_error", "force_offset", "force_gain_error"}
EVERY_PHENOMENON = pytest.mark.parametrize("name", PHENOMENA)


@pytest.fixture(scope="module")
def rough() -> Drive:
    """10 mm RMS with a current: excites everything."""
    drive = bench_drive("random10", SETUP.damper, 6.0, 1, STEP)
    return replace(drive, current=current_steps(6.0, 1, STEP))


def test_every_phenomenon_of_the_vocabulary_exists() -> None:
    assert set(PHENOMENA) == CHAIN | {
        "gas_spring", "friction", "oil_compressibility", "blow_off", "valve_delay", "cavitation", "temperature_fade",
        "position_dependence", "end_stop", "mount_compliance", "inertia", "asymmetry", "current", "hysteresis",
    }  # fmt: skip


@EVERY_PHENOMENON
def test_a_phenomenon_touches_the_damper_or_the_sensors_not_both(name: str) -> None:
    phenomenon = PHENOMENA[name]
    off, on = phenomenon.off(SETUP, 2.0), phenomenon.on(SETUP, 2.0)
    assert (off.sensors == on.sensors) is (name not in CHAIN)
    assert (off.damper == on.damper) is (name in CHAIN)
    assert phenomenon.signed is (name in CHAIN)


@EVERY_PHENOMENON
def test_switching_twice_is_switching_once(name: str) -> None:
    phenomenon = PHENOMENA[name]
    off = phenomenon.off(SETUP, 1.0)
    assert name == "cavitation" or phenomenon.off(off, 1.0) == off


@EVERY_PHENOMENON
@pytest.mark.parametrize("damper", DAMPERS.values(), ids=DAMPERS)
def test_a_larger_magnitude_shows_more_in_every_damper(name: str, damper: object, rough: Drive) -> None:
    setup = Setup(damper, Sensors())
    phenomenon = PHENOMENA[name]
    short = Drive("part", STEP, rough.displacement[9000:19000], rough.current[9000:19000])
    # The ring gap of a cold semi-active damper and its coil hide small changes: magnitudes are far apart.
    weak, strong = (
        strength(phenomenon.off(setup, magnitude), phenomenon.on(setup, magnitude), short) for magnitude in (0.7, 5.0)
    )
    assert strong > 1.2 * weak
    assert strong > 0.002


@pytest.mark.parametrize("name", ["friction", "oil_compressibility", "cavitation", "mount_compliance", "gas_spring"])
@pytest.mark.parametrize("wanted", [0.04, 0.2])
def test_the_calibrated_strength_is_reached(name: str, wanted: float, rough: Drive) -> None:
    found = calibrate(name, SETUP, rough, wanted)
    assert found.strength == pytest.approx(wanted, rel=0.03)
    off, on = switched(SETUP, (found,))
    forces = [in_band(simulate(setup.damper, rough).force, rough.step) for setup in (off, on)]
    difference = relative_difference(*forces)
    assert difference == pytest.approx(found.strength, rel=1e-9)


@pytest.mark.parametrize("name", sorted(CHAIN))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_errors_of_the_chain_go_both_ways(name: str, sign: float, rough: Drive) -> None:
    found = calibrate(name, SETUP, rough, 0.1, sign)
    assert found.magnitude * sign > 0.0
    assert found.strength == pytest.approx(0.1, rel=0.03)


def test_a_record_that_does_not_excite_an_effect_reports_it() -> None:
    slow = bench_drive("slow", SETUP.damper, 8.0, 1, STEP)
    for name in ("end_stop", "inertia", "cavitation"):
        assert calibrate(name, SETUP, slow, 0.1).strength < 0.03


def test_an_impossible_strength_is_refused(rough: Drive) -> None:
    with pytest.raises(ValueError, match="between 0 and 1"):
        calibrate("friction", SETUP, rough, 1.5)


def drives(*names: str) -> tuple[Drive, ...]:
    return tuple(bench_drive(name, SETUP.damper, 6.0, seed, STEP) for seed, name in enumerate(names))


def test_a_case_hides_the_effect_in_fit_and_unseen_but_not_in_base() -> None:
    case = hidden(("mount_compliance",), SETUP, drives("random", "random", "dyno"), 0.1, seed=3)
    assert case.base.setup.damper == without(SETUP, ("mount_compliance",)).damper
    assert case.fit.setup == case.unseen.setup
    assert case.fit.setup.damper.mount.stiffness > 0.0
    assert case.fit_strength == pytest.approx(0.1, rel=0.03)
    assert case.unseen_strength > 0.03


def test_two_effects_are_hidden_together_each_at_its_strength() -> None:
    case = hidden(("friction", "channel_skew"), SETUP, drives("random", "random", "random"), 0.1, seed=3)
    assert [item.phenomenon for item in case.calibrations] == ["friction", "channel_skew"]
    assert all(item.strength == pytest.approx(0.1, rel=0.03) for item in case.calibrations)
    assert case.base.setup.damper.seal.force == 0.0
    assert case.fit.setup.sensors.skew == pytest.approx(1e-3 * case.calibrations[1].magnitude)
    assert 0.1 < case.fit_strength < 0.2


def test_with_nothing_hidden_all_records_are_of_one_setup() -> None:
    case = hidden((), SETUP, drives("random", "random", "random"), 0.1, seed=3)
    assert case.base.setup == case.fit.setup == case.unseen.setup == SETUP
    assert case.fit_strength == case.unseen_strength == 0.0


def test_frequencies_above_the_band_do_not_count() -> None:
    time = np.arange(20000) * STEP
    slow, fast = np.sin(2 * np.pi * 5.0 * time), np.sin(2 * np.pi * 150.0 * time)
    middle = slice(3000, 17000)
    assert in_band(slow, STEP)[middle] == pytest.approx(slow[middle], abs=1e-3)
    assert np.abs(in_band(fast, STEP)[middle]).max() < 1e-3
