"""Conservation, statics, dissipation and cavitation of the simulated damper."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.plant import DAMPERS, PHENOMENA, STEP, Damper, Drive, Sensors, Setup, simulate
from damper_estimator.plant.damper import packed_share, parts_of
from damper_estimator.plant.parts import AMBIENT_PRESSURE

PASSENGER = DAMPERS["passenger_front"]
EVERY_DAMPER = pytest.mark.parametrize("damper", DAMPERS.values(), ids=DAMPERS)


def drive_of(displacement: np.ndarray, step: float = STEP) -> Drive:
    return Drive("test", step, displacement, np.zeros_like(displacement))


def sine(amplitude: float, frequency: float, cycles: int, step: float = STEP) -> Drive:
    """Starts and ends at rest at its lowest point; whole cycles."""
    time = step * np.arange(round(cycles / frequency / step) + 1)
    return drive_of(-amplitude * np.cos(2.0 * np.pi * frequency * time), step)


@EVERY_DAMPER
def test_force_at_rest_is_the_gas_pressure_on_the_rod(damper: Damper) -> None:
    truth = simulate(damper, drive_of(np.zeros(50)))
    expected = -(damper.gas.pressure - AMBIENT_PRESSURE) * pi / 4 * damper.geometry.rod**2
    assert truth.force == pytest.approx(expected, rel=1e-9)


@EVERY_DAMPER
def test_force_at_rest_follows_the_polytropic_gas_as_the_rod_goes_in(damper: Damper) -> None:
    deep = -0.7 * damper.geometry.compression_stroke
    truth = simulate(damper, drive_of(np.full(50, deep)))
    share = (damper.geometry.rod / damper.geometry.bore) ** 2
    pressure = damper.gas.pressure * (1.0 + share * deep / damper.gas.length) ** -damper.gas.exponent
    # The oil is compressed a little, so the gas is compressed by less than the rod's volume.
    assert truth.gas_pressure == pytest.approx(pressure, rel=5e-3)
    assert truth.gas_pressure[0] < pressure


def test_a_through_rod_feels_no_gas() -> None:
    truth = simulate(PASSENGER.with_part("geometry", tail_rod=1.0), drive_of(np.full(50, 0.02)))
    assert np.abs(truth.force).max() < 1e-6


@EVERY_DAMPER
@pytest.mark.parametrize("phenomenon", ["friction", "mount_compliance", "valve_delay", "hysteresis", "cavitation"])
def test_without_motion_the_force_does_not_change(damper: Damper, phenomenon: str) -> None:
    on = PHENOMENA[phenomenon].on(Setup(damper, Sensors()), 2.0).damper
    force = simulate(on, drive_of(np.full(2000, 0.013))).force
    assert np.ptp(force) < 1e-5 * max(abs(force[0]), 1.0)


@EVERY_DAMPER
def test_oil_is_conserved(damper: Damper) -> None:
    truth = simulate(damper, sine(0.03, 4.0, 4))
    chambers = parts_of(damper).chambers
    place = chambers.piston_area * truth.floating_piston
    rebound = chambers.rebound_volume - chambers.rebound_area * truth.rod
    compression = chambers.compression_volume + chambers.compression_area * truth.rod + place
    liquid = rebound * (1.0 + packed_share(damper.oil, truth.rebound_pressure))
    liquid = liquid + compression * (1.0 + packed_share(damper.oil, truth.compression_pressure))
    assert liquid == pytest.approx(liquid[0], rel=1e-9)


@settings(max_examples=25, deadline=None)
@given(
    amplitude=st.floats(0.002, 0.04),
    frequency=st.floats(1.0, 12.0),
    stiffer=st.floats(0.2, 4.0),
    needle=st.floats(0.3, 3.0),
    name=st.sampled_from(sorted(DAMPERS)),
)
def test_a_closed_cycle_dissipates_energy(
    amplitude: float, frequency: float, stiffer: float, needle: float, name: str
) -> None:
    damper = DAMPERS[name].with_part("oil", bulk_modulus=stiffer * DAMPERS[name].oil.bulk_modulus)
    damper = damper.with_part("piston", bleed_area=needle * damper.piston.bleed_area)
    drive = sine(min(amplitude, 0.3 / frequency), frequency, 3)
    truth = simulate(damper, drive)
    last = slice(round(2.0 / frequency / STEP), None)
    work = np.sum(truth.force[last] * drive.velocity[last]) * STEP
    valves = (truth.rebound_pressure - truth.compression_pressure)[last] * drive.velocity[last]
    assert work > 0.0
    assert np.sum(valves) > 0.0


def test_rebound_pulls_and_compression_pushes_harder_than_rest() -> None:
    drive = sine(0.03, 2.0, 3)
    truth = simulate(PASSENGER, drive)
    assert truth.force[drive.velocity > 0.1].min() > 0.0
    assert truth.force[drive.velocity < -0.1].max() < truth.force[0]


class TestCavitation:
    """Fast compression with a low charge."""

    damper = PASSENGER.with_part("gas", pressure=2.5e5)
    drive = sine(0.03, 5.0, 3)

    def test_the_chamber_never_falls_below_vapour_pressure(self) -> None:
        lowest = simulate(self.damper, self.drive).rebound_pressure.min()
        assert self.damper.oil.vapour_pressure < lowest < 3.0 * self.damper.oil.vapour_pressure

    def test_the_gas_pressure_limits_the_force(self) -> None:
        truth = simulate(self.damper, self.drive)
        area = pi / 4 * self.damper.geometry.bore**2
        clamp = area * (truth.gas_pressure.max() - AMBIENT_PRESSURE) + 150.0  # seals, floating piston
        assert -truth.force.min() < clamp
        assert -simulate(PASSENGER, self.drive).force.min() > 1.5 * clamp

    def test_a_void_grows_and_is_filled_again_before_the_force_returns(self) -> None:
        truth = simulate(self.damper, self.drive)
        void = truth.rebound_void
        assert void.max() > 2e-6
        after_rebound = round(2.5 / 5.0 / STEP)
        assert void[after_rebound] < 0.01 * void.max()
        full = simulate(self.damper.with_part("oil", vapour_pressure=-5e7), self.drive)
        refilling = (void > 0.3 * void.max()) & (self.drive.velocity > 0.1)
        assert refilling.any()
        assert (truth.force[refilling] < full.force[refilling] - 100.0).all()

    def test_liquid_that_withstands_tension_forms_no_void(self) -> None:
        full = simulate(self.damper.with_part("oil", vapour_pressure=-5e7), self.drive)
        assert full.rebound_pressure.min() < 0.0
        assert full.rebound_void.max() < 1e-7


def test_oil_is_softer_at_low_pressure() -> None:
    low, high = 3e5, 50e5
    oil = PASSENGER.oil

    def bulk(pressure: float) -> float:
        return 1e3 / (packed_share(oil, pressure + 1e3) - packed_share(oil, pressure))

    assert bulk(low) < 0.3 * bulk(high)
    assert bulk(high) == pytest.approx(oil.bulk_modulus, rel=0.05)


def test_dissipated_power_heats_the_oil_and_thins_it() -> None:
    hot = PHENOMENA["temperature_fade"].on(Setup(PASSENGER, Sensors()), 20.0).damper
    drive = sine(0.03, 3.0, 9)
    truth, cool = simulate(hot, drive), simulate(PASSENGER, drive)
    adiabatic = 0.08 * np.sum(cool.force * drive.velocity) * STEP
    assert truth.temperature[0] == 40.0
    assert 0.7 * adiabatic < truth.temperature[-1] - 40.0 < 1.1 * adiabatic
    last = slice(-round(1.0 / 3.0 / STEP), None)
    assert np.std(truth.force[last]) < 0.98 * np.std(cool.force[last])
