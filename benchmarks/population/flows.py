"""Passages, stored oil and gas: one evaluation each (compiled)."""

from math import exp, log, sqrt

from damper_estimator.compiled import compiled
from population.plant_parameters import AMBIENT

DISCHARGE = 0.7
VOID = 1e-6
"""1/Pa, compliance below vapour pressure."""


@compiled
def orifice(area, pressure, transition, density):
    """Flow in m^3/s through a hole, laminar well below ``transition`` (Pa)."""
    size = DISCHARGE * area * sqrt(2.0 / density)
    return size * pressure / sqrt(sqrt(pressure * pressure + transition * transition))


@compiled
def opening(plant, pressure, crack, gradient, port):
    """Flow area in m^2 of the valve over its passage at ``pressure`` >= 0."""
    beyond = pressure - crack
    if beyond <= 0.0:
        return 0.0
    beyond *= beyond / (beyond + 0.15 * crack + 1e4)
    if plant.valve_form == 1:  # stack of shims: a stiffer one engages
        if beyond > plant.step:
            beyond = plant.step + plant.step_ratio * (beyond - plant.step)
    elif plant.valve_form == 2:  # spool that the flow pulls closed
        beyond /= 1.0 + beyond / plant.step
    area = gradient * beyond
    return area * port / sqrt(area * area + port * port)


@compiled
def blow_off(plant, pressure):
    """Flow area in m^2 of the relief passage at ``pressure``, of either sign."""
    if plant.blow_form == 0:
        return 0.0
    side = 1 if pressure > 0.0 else 2
    if plant.blow_side != 3 and plant.blow_side != side:
        return 0.0
    start = plant.blow_pressure
    beyond = abs(pressure) - start
    if beyond <= 0.0:
        return 0.0
    if plant.blow_form == 1:  # preloaded poppet: the jet's force closes it
        return plant.blow_gain * beyond / (1.0 + abs(pressure) / (2.0 * start))
    if plant.blow_form == 2:  # shims bend and tilt: more than in proportion
        return plant.blow_gain * beyond * sqrt(beyond / start)
    lift = min(beyond / (0.6 * start), 1.0)  # spool with triangular slots, up to its stop
    return plant.blow_gain * 0.6 * start * lift * lift


@compiled
def placed(plant, x, pressure):
    """Flow area in m^2 of position-dependent passages."""
    form, centre, width = plant.place_form, plant.place_centre, plant.place_width
    if form == 0:
        return 0.0
    if form == 1:  # flat groove in the tube with tapered ends
        away = abs(x - centre)
        return plant.place_area * min(max((1.4 * width - away) / (0.4 * width), 0.0), 1.0)
    if form == 2:  # ports in the tube with a check: uncovered one after the other, only in rebound
        if pressure < 0.0:
            return 0.0
        share = min(max((x - centre) / (2.0 * width) + 0.5, 0.0), 1.0)
        return plant.place_area * share * sqrt(share)
    # metering pin: open in the middle of the stroke, narrower towards both ends
    away = (x - centre) / plant.stroke
    return plant.place_area / (1.0 + 6.0 * away * away)


@compiled
def viscosity(plant, temperature):
    """Of the oil, relative to that at 30 deg C."""
    warmer = temperature - 30.0
    if plant.warm_form == 2:  # Vogel: steeper where it is cold
        return exp(plant.warm * 110.0 * 110.0 * (1.0 / (110.0 + warmer) - 1.0 / 110.0))
    return exp(-plant.warm * warmer)


@compiled
def through_piston(plant, pressure, x, thin, area_r, area_c, field):
    """Flow in m^3/s from rebound to compression chamber; the areas of the valves are given."""
    density, transition = plant.density, plant.transition * thin * thin
    hole = plant.bleed
    if plant.current_form == 4:  # solenoid needle in the bleed
        hole *= max(1.0 - plant.current * field, 0.05)
    hole += placed(plant, x, pressure)
    flow = pressure * plant.leak / thin + orifice(hole, pressure, transition, density)
    flow += orifice(blow_off(plant, pressure), pressure, 2e3, density)
    if plant.delay_form == 4:  # the valve of the other direction has not closed yet
        flow += orifice(area_c if pressure > 0.0 else area_r, pressure, 2e3, density)
    if pressure > 0.0:
        return flow + orifice(area_r, pressure, 2e3, density)
    return flow + orifice(area_c + plant.check_c, pressure, transition, density)


@compiled
def valve_areas(plant, pressure, field):
    """Steady areas of rebound and compression valve at a pressure."""
    stiffer = 1.0 + plant.current * field if plant.current_form == 5 else 1.0
    if pressure > 0.0:
        return opening(plant, pressure, plant.crack_r * stiffer, plant.grad_r, plant.port_r), 0.0
    return 0.0, opening(plant, -pressure, plant.crack_c * stiffer, plant.grad_c, plant.port_c)


@compiled
def lagged(plant, state, pressure, field, step):
    """Advances the areas of lagging valves; ``state``: area and its rate (or pilot pressure), rebound and
    compression."""
    tau = plant.delay
    target_r, target_c = valve_areas(plant, pressure, field)
    for side in range(2):
        target = target_r if side == 0 else target_c
        at = 2 * side
        if plant.delay_form == 1:  # a mass on a spring, well damped
            omega = 1.6 / tau
            pull = omega * omega * (target - state[at]) - 1.6 * omega * state[at + 1]
            state[at + 1] += step * pull
            state[at] = max(state[at] + step * state[at + 1], 0.0)
        elif plant.delay_form == 2:  # a squeezed film holds the disc on its seat; it shuts faster
            port = plant.port_r if side == 0 else plant.port_c
            if target > state[at]:
                rate = (state[at] + 0.03 * port) / (0.12 * port) / tau
                state[at] += (target - state[at]) * (1.0 - exp(-step * min(rate, 4.0 / tau)))
            else:
                state[at] += (target - state[at]) * (1.0 - exp(-2.5 * step / tau))
        elif plant.delay_form == 4:  # opens at once; a weak spring and the pressure from behind close it steadily
            port, crack = (plant.port_r, plant.crack_r) if side == 0 else (plant.port_c, plant.crack_c)
            behind = max(-pressure if side == 0 else pressure, 0.0)
            state[at] = max(state[at] - step / tau * port * (0.2 + behind / crack), target)
        else:  # a pilot chamber that an orifice fills controls the valve
            opening_pressure = max(pressure, 0.0) if side == 0 else max(-pressure, 0.0)
            crack = plant.crack_r if side == 0 else plant.crack_c
            rate = 1.0 / (tau * sqrt(abs(opening_pressure - state[at + 1]) / crack + 0.02))
            state[at + 1] += (opening_pressure - state[at + 1]) * (1.0 - exp(-step * rate))
            gradient, port = (plant.grad_r, plant.port_r) if side == 0 else (plant.grad_c, plant.port_c)
            state[at] = opening(plant, state[at + 1], crack, gradient, port)


@compiled
def stored(plant, pressure, gas):
    """Oil compressed into a chamber at ``pressure`` (Pa), relative to the chamber's volume; ``gas`` is its free
    share."""
    packed = pressure / plant.bulk
    if plant.wall > 0.0:
        over = pressure / plant.wall_pressure
        packed += plant.wall * plant.wall_pressure * (log(1.0 + over) if over > 0.0 else over)
    if pressure > plant.low:
        packed += gas * (1.0 - AMBIENT / pressure)
    else:
        packed += gas * (1.0 - AMBIENT / plant.low + (pressure - plant.low) * AMBIENT / (plant.low * plant.low))
    if pressure < plant.vapour:
        packed += VOID * (pressure - plant.vapour)
    return packed


@compiled
def gas_pressure(plant, x, warmer, state, step, moved):
    """Pressure in Pa behind the floating piston or in the reserve; ``state``: the gas's warmth and the stuck share."""
    taken = plant.rod * x
    charge = plant.charge * (1.0 + plant.warm_gas * warmer)
    volume = max(plant.gas_volume + taken, 0.08 * plant.gas_volume)
    if plant.gas_form == 1:  # heat flows to the wall: adiabatic when fast, isothermal when slow
        if step > 0.0:
            state[0] *= 1.0 - (plant.exponent - 1.0) * plant.rod * moved / volume
            state[0] += (1.0 - state[0]) * (1.0 - exp(-step / plant.gas_relax))
        return charge * plant.gas_volume / volume * state[0]
    if plant.gas_form == 2:  # Noble and Abel: part of the volume cannot be compressed
        incompressible = plant.covolume * plant.gas_volume
        return (
            charge
            * ((plant.gas_volume - incompressible) / max(volume - incompressible, 0.05 * plant.gas_volume))
            ** plant.exponent
        )
    # the floating piston sticks to the tube
    state[1] = min(max(state[1] + moved / 6e-4, -1.0), 1.0)
    return charge * (plant.gas_volume / volume) ** plant.exponent - plant.gas_stick * state[1]


@compiled
def gelled(plant, state, travel, step):
    """Yield pressure in Pa of a fluid with memory after a further ``travel`` (m)."""
    if plant.gel_form == 1:  # layers that yield one after the other
        held = 0.0
        for layer in range(4):
            reach = plant.gel_reach * (0.25, 0.6, 1.2, 2.5)[layer]
            state[layer] = min(max(state[layer] + travel / reach, -1.0), 1.0)
            held += 0.25 * state[layer]
        return plant.gel * held
    strain = abs(travel) / plant.gel_reach
    if plant.gel_form == 2:  # strained like a solid, flows, and relaxes at rest
        sign = 1.0 if travel > 0.0 else -1.0
        state[0] = sign + (state[0] - sign) * exp(-strain) if strain > 0.0 else state[0]
        state[0] *= exp(-0.1 * step / plant.gel_time)
        return plant.gel * state[0]
    # thixotropic: motion destroys a structure that grows again
    state[1] += (1.0 - state[1]) * step / plant.gel_time - state[1] * 0.02 * strain
    state[0] = min(max(state[0] + travel / plant.gel_reach, -1.0), 1.0)
    return plant.gel * state[0] * (0.6 + 0.6 * state[1])
