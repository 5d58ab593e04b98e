"""Pressures, openings and flows inside the damper, one evaluation each (compiled).

Sources: H. H. Lang, A study of the characteristics of automotive hydraulic dampers at high stroking frequencies (1977),
for the balance of compressible chambers; J. Duym, Simulation tools, modelling and identification, for an automotive
shock absorber in the context of vehicle dynamics, Vehicle System Dynamics 33 (2000), for the stages of the valves.
"""

from math import exp, sqrt

from damper_estimator.compiled import compiled
from damper_estimator.plant.parts import AMBIENT_PRESSURE

SEAT_PRESSURE = 2000.0
"""Pa, below which the flow past a disc valve is laminar; keeps its slope finite at zero pressure."""


@compiled
def liquid_pressure(oil, excess, volume):
    """Pressure of a chamber in Pa from its liquid's excess (m^3 at zero pressure, beyond the volume) and volume.

    Solves p'/B - g p_ambient / p' = excess / volume for p' = p - p_vapour: stiff liquid where it is compressed; where
    volume is missing the free gas fraction g expands, and the pressure stays at vapour pressure while a void grows.
    """
    stress = oil.bulk_modulus * excess / volume
    product = oil.bulk_modulus * oil.free_gas * AMBIENT_PRESSURE
    root = sqrt(stress * stress + 4.0 * product)
    # The smaller root suffers from cancellation; it follows from the product of both.
    above = 0.5 * (stress + root) if stress > 0.0 else 2.0 * product / (root - stress)
    return oil.vapour_pressure + above


@compiled
def gas_pressure(gas, rest_volume, piston_volume, warmth):
    """Polytropic gas in Pa: p = p0 warmth (V0 / (V0 - piston_volume))^n.

    ``warmth`` is the absolute temperature over that at the start. At 3 % of its volume the floating piston bottoms, and
    the pressure no longer rises.
    """
    volume = max(rest_volume - piston_volume, 0.03 * rest_volume)
    return gas.pressure * warmth * (rest_volume / volume) ** gas.exponent


@compiled
def ramp(excess, width):
    """max(excess, 0) with its corner rounded by a parabola within +-width; exactly zero below."""
    if excess <= -width:
        return 0.0
    return excess if excess >= width else (excess + width) ** 2 / (4.0 * width)


@compiled
def lift_area(valve, pressure):
    """Flow area in m^2 of the discs lifted at ``pressure`` (Pa, in the valve's direction), without the port."""
    main = valve.gradient * ramp(pressure - valve.crack, valve.rounding * valve.crack)
    return main + valve.relief_gradient * ramp(pressure - valve.relief, valve.rounding * valve.relief)


@compiled
def disc_flow(valve, area, pressure, density):
    """Flow in m^3/s, >= 0, through lifted discs (``area``) and the port behind them: 1/A^2 = 1/area^2 + 1/port^2."""
    series = area * valve.port / sqrt(area * area + valve.port * valve.port)
    return series * sqrt(2.0 / density) * pressure / sqrt(sqrt(pressure * pressure + SEAT_PRESSURE * SEAT_PRESSURE))


@compiled
def orifice_flow(area, transition, pressure, viscosity, density):
    """Flow in m^3/s through a short orifice: the root of R Q + K Q |Q| = pressure.

    K = density / (2 area^2) is the turbulent drop; the laminar R, proportional to ``viscosity`` (relative to 40 deg C),
    makes both equal at the pressure ``transition``.
    """
    turbulent = 0.5 * density / (area * area)
    laminar = viscosity * sqrt(0.5 * turbulent * transition)
    return 2.0 * pressure / (laminar + sqrt(laminar * laminar + 4.0 * turbulent * abs(pressure)))


@compiled
def groove_area(piston, displacement):
    """Bypass area in m^2 around the piston: a smooth hump about the groove's centre."""
    distance = (displacement - piston.groove_centre) / piston.groove_width
    return piston.groove_area * exp(-distance * distance * distance * distance)


@compiled
def piston_flow(parts, rebound_area, compression_area, pressure, displacement, viscosity):
    """Flow in m^3/s from rebound to compression chamber at the pressure difference ``pressure`` (Pa).

    Always open: needle, groove, ring gap. Behind checks: the rebound discs for positive pressure, the compression discs
    for negative; ``*_area`` is the lifted area of each, in m^2.
    """
    piston, density = parts.piston, parts.oil.density
    flow = pressure * piston.ring_gap / viscosity
    open_area = piston.bleed_area + groove_area(piston, displacement)
    flow += orifice_flow(open_area, piston.bleed_transition, pressure, viscosity, density)
    if pressure > 0.0:
        return flow + disc_flow(parts.rebound, rebound_area, pressure, density)
    return flow - disc_flow(parts.compression, compression_area, -pressure, density)
