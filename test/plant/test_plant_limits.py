"""The simulated damper against closed forms, in limits of single phenomena."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.plant import DAMPERS, PHENOMENA, STEP, Damper, Drive, Sensors, Setup, simulate
from damper_estimator.plant.damper import Parts, parts_of
from damper_estimator.plant.hydraulics import lift_area, piston_flow

PASSENGER = DAMPERS["passenger_front"]
EVERY_DAMPER = pytest.mark.parametrize("damper", DAMPERS.values(), ids=DAMPERS)


def two_tones(seconds: float = 1.5, step: float = STEP) -> Drive:
    time = step * np.arange(round(seconds / step))
    rise = np.clip(time / 0.2, 0.0, 1.0) ** 3
    motion = rise * (0.012 * np.sin(2.0 * np.pi * 2.3 * time) + 0.003 * np.sin(2.0 * np.pi * 9.1 * time))
    return Drive("tones", step, motion, np.zeros_like(motion))


def off(damper: Damper, *names: str) -> Damper:
    for name in names:
        damper = PHENOMENA[name].off(Setup(damper, Sensors()), 1.0).damper
    return damper


def on(damper: Damper, name: str, magnitude: float) -> Damper:
    return PHENOMENA[name].on(Setup(damper, Sensors()), magnitude).damper


def steady_pressure(parts: Parts, velocity: float) -> float:
    """Pressure difference at which the piston passes all the oil that it displaces (bisection)."""
    low, high = -2e8, 2e8
    for _ in range(60):
        middle = 0.5 * (low + high)
        areas = lift_area(parts.rebound, middle), lift_area(parts.compression, -middle)
        flow = piston_flow(parts, *areas, middle, 0.0, 1.0)
        low, high = (middle, high) if flow < parts.chambers.rebound_area * velocity else (low, middle)
    return middle


@EVERY_DAMPER
def test_with_stiff_oil_the_pressure_is_the_quasi_static_valve_curve(damper: Damper) -> None:
    stiff, drive = off(damper, "oil_compressibility", "current"), two_tones()
    truth = simulate(stiff, drive)
    some = slice(3000, None, 97)
    parts = parts_of(stiff)
    expected = np.array([steady_pressure(parts, velocity) for velocity in drive.velocity[some]])
    error = (truth.rebound_pressure - truth.compression_pressure)[some] - expected
    assert np.sqrt(np.mean(error**2)) < 0.02 * np.sqrt(np.mean(expected**2))


@EVERY_DAMPER
def test_soft_oil_opens_the_loop_more_at_higher_frequency(damper: Damper) -> None:
    soft = on(off(damper, "friction", "current"), "oil_compressibility", 6.0)

    def lag(frequency: float) -> float:
        """Velocity at which the force equals its value at rest, relative to the peak velocity."""
        time = STEP * np.arange(round(3.0 / frequency / STEP))
        drive = Drive("sine", STEP, 0.002 * np.cos(2.0 * np.pi * frequency * time), np.zeros_like(time))
        truth = simulate(soft, drive)
        late = time > 2.0 / frequency
        rising = np.argmin(np.abs(truth.force[late] - truth.force[0]) + 1e9 * (drive.acceleration[late] < 0.0))
        return drive.velocity[late][rising] / drive.velocity.max()

    assert lag(12.0) > lag(3.0) > 0.0


@EVERY_DAMPER
def test_a_stiffer_lighter_mount_approaches_no_mount(damper: Damper) -> None:
    drive = two_tones()
    rigid = simulate(damper, drive).force

    def deviation(stiffness: float) -> float:
        mounted = damper.with_part("mount", stiffness=stiffness, damping=1e-4 * stiffness, rod_mass=0.01)
        return np.sqrt(np.mean((simulate(mounted, drive).force - rigid) ** 2)) / np.std(rigid)

    assert deviation(4e7) < 0.4 * deviation(4e6)
    assert deviation(4e7) < 0.02


def test_a_soft_mount_absorbs_part_of_the_stroke() -> None:
    drive = two_tones()
    truth = simulate(on(PASSENGER, "mount_compliance", 3.0), drive)
    deflection = drive.displacement - truth.rod
    mount = on(PASSENGER, "mount_compliance", 3.0).mount
    elastic = mount.stiffness * deflection * (1.0 + (deflection / mount.progression) ** 2)
    assert np.abs(deflection).max() > 3e-4
    assert np.corrcoef(elastic, truth.force)[0, 1] > 0.98


def test_fast_shims_follow_immediately() -> None:
    drive = two_tones()
    fast, none = (simulate(on(PASSENGER, "valve_delay", 0.02), drive).force, simulate(PASSENGER, drive).force)
    assert np.sqrt(np.mean((fast - none) ** 2)) < 5e-3 * np.std(none)


def test_slow_shims_overshoot_on_opening_and_lack_force_on_closing() -> None:
    drive = two_tones()
    difference = simulate(on(PASSENGER, "valve_delay", 5.0), drive).force - simulate(PASSENGER, drive).force
    open_rebound = drive.velocity > 0.15
    assert difference[open_rebound & (drive.acceleration > 3.0)].mean() > 10.0
    assert difference[open_rebound & (drive.acceleration < -3.0)].mean() < -10.0


def test_inertia_adds_mass_times_acceleration() -> None:
    drive = two_tones()
    difference = simulate(on(PASSENGER, "inertia", 3.0), drive).force - simulate(PASSENGER, drive).force
    assert difference == pytest.approx(3.0 * drive.acceleration, abs=1e-9 * np.abs(drive.acceleration).max() + 1e-9)


def test_equal_valves_produce_equal_pressures_in_both_directions() -> None:
    parts = parts_of(off(PASSENGER, "asymmetry"))
    for velocity in (0.02, 0.1, 0.4, 1.0):
        assert steady_pressure(parts, velocity) == pytest.approx(-steady_pressure(parts, -velocity), rel=1e-6)
    ordinary = parts_of(PASSENGER)
    assert steady_pressure(ordinary, 0.4) > -1.2 * steady_pressure(ordinary, -0.4)


def test_asymmetry_of_magnitude_one_is_the_ordinary_damper() -> None:
    leaning = on(PASSENGER, "asymmetry", 1.0)
    assert np.allclose(leaning.rebound, PASSENGER.rebound, rtol=1e-12)
    assert np.allclose(leaning.compression, PASSENGER.compression, rtol=1e-12)


def test_the_blow_off_bends_the_curve_only_beyond_its_opening() -> None:
    closed, opened = parts_of(off(PASSENGER, "blow_off")), parts_of(PASSENGER)
    assert steady_pressure(opened, 0.05) == pytest.approx(steady_pressure(closed, 0.05), rel=1e-9)
    assert steady_pressure(opened, 1.2) < 0.8 * steady_pressure(closed, 1.2)


def test_a_softer_adjuster_lowers_the_force_at_low_speed_most() -> None:
    hard, soft = (parts_of(replace(PASSENGER, adjuster=opening)) for opening in (0.0, 1.0))
    low = steady_pressure(soft, 0.05) / steady_pressure(hard, 0.05)
    high = steady_pressure(soft, 1.0) / steady_pressure(hard, 1.0)
    assert low < 0.6 < high


def test_the_groove_softens_the_damper_where_it_is() -> None:
    bypass = on(PASSENGER, "position_dependence", 2.0).piston
    parts = parts_of(PASSENGER)._replace(piston=bypass)
    areas = lift_area(parts.rebound, 3e5), lift_area(parts.compression, -3e5)
    inside, outside = (piston_flow(parts, *areas, 3e5, place, 1.0) for place in (bypass.groove_centre, 0.03))
    assert inside > 1.5 * outside


def test_more_current_more_force_after_the_field_has_built_up() -> None:
    damper, drive = DAMPERS["semi_active"], two_tones()
    forces = [
        simulate(damper, Drive("tones", STEP, drive.displacement, np.full_like(drive.displacement, amperes))).force
        for amperes in (0.0, 1.0, 2.0)
    ]
    assert np.std(forces[0]) < np.std(forces[1]) < np.std(forces[2])
    late = np.where(drive.time < 0.75, 0.0, 2.0)
    stepped = simulate(damper, Drive("tones", STEP, drive.displacement, late))
    before, after = drive.time < 0.75, drive.time > 0.75 + 6 * damper.coil.time
    assert np.array_equal(stepped.force[before], forces[0][before])
    assert stepped.field[after] == pytest.approx(2.0, rel=0.01)


def test_the_bump_stop_pushes_only_beyond_its_position() -> None:
    damper = on(PASSENGER, "end_stop", 2.0)
    time = STEP * np.arange(10000)
    drive = Drive("sine", STEP, 0.03 * np.sin(2.0 * np.pi * 2.0 * time), np.zeros_like(time))
    difference = simulate(damper, drive).force - simulate(PASSENGER, drive).force
    inside = (drive.displacement > damper.stops.compression) & (drive.displacement < damper.stops.rebound)
    assert np.abs(difference[inside]).max() == 0.0
    assert difference[drive.displacement < damper.stops.compression - 0.004].max() < -50.0
    assert difference[drive.displacement > damper.stops.rebound + 0.004].min() > 50.0


def test_a_displacement_beyond_the_stroke_is_refused() -> None:
    with pytest.raises(ValueError, match="leaves the stroke of passenger_front"):
        simulate(PASSENGER, Drive("far", STEP, np.full(10, 0.2), np.zeros(10)))


def test_a_displacement_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        simulate(PASSENGER, Drive("nan", STEP, np.full(10, np.nan), np.zeros(10)))
