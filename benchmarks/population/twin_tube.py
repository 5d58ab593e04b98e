"""Twin-tube damper: two chambers and a reserve behind a foot valve; two pressures at each step (compiled)."""

import numpy as np

from damper_estimator.compiled import compiled
from population.common_step import MEMORY, aerate, gauge_force, magnetise, rod_motion, rod_side, settle
from population.flows import gas_pressure, gelled, lagged, orifice, stored, through_piston, valve_areas, viscosity
from population.friction_and_stops import rubbed, stopped
from population.plant_parameters import AMBIENT


@compiled
def through_foot(plant, pressure, thin):
    """Flow in m^3/s from the compression chamber into the reserve: throttled outwards, through a check inwards."""
    transition = plant.transition * thin * thin
    if pressure <= 0.0:
        return orifice(plant.foot_bleed + plant.intake, pressure, 1e3, plant.density)
    beyond = pressure - plant.foot_crack
    area = plant.foot_bleed
    flow = orifice(area, pressure, transition, plant.density)
    if beyond > 0.0:
        lift = plant.foot_grad * beyond * beyond / (beyond + 0.15 * plant.foot_crack)
        port = plant.intake
        flow += orifice(lift * port / (lift + port), pressure, 1e3, plant.density)
    return flow


@compiled
def flows(plant, p1, p2, reserve, held, x, thin, valves, field):
    """Flows in m^3/s through the piston and out through the foot valve."""
    pressure = p1 - p2 - held
    area_r, area_c = valves[0], valves[2]
    if plant.delay_form == 0:
        area_r, area_c = valve_areas(plant, pressure, field)
    through = through_piston(plant, pressure, x, thin, area_r, area_c, field)
    return through, through_foot(plant, p2 - reserve, thin)


@compiled
def solve(plant, e1, e2, volume1, volume2, step, p1, p2, reserve, held, x, thin, valves, field, gas):
    """Both pressures in Pa at the end of a step: Newton's method with steps halved until they improve."""
    through, out = flows(plant, p1, p2, reserve, held, x, thin, valves, field)
    r1 = volume1 * stored(plant, p1, gas) - e1 + step * through
    r2 = volume2 * stored(plant, p2, gas) - e2 - step * through + step * out
    for _ in range(80):
        more, _ = flows(plant, p1 + 200.0, p2, reserve, held, x, thin, valves, field)
        _, further = flows(plant, p1, p2 + 200.0, reserve, held, x, thin, valves, field)
        slope, foot = step * (more - through) / 200.0, step * (further - out) / 200.0
        c1 = volume1 * (stored(plant, p1 + 200.0, gas) - stored(plant, p1, gas)) / 200.0
        c2 = volume2 * (stored(plant, p2 + 200.0, gas) - stored(plant, p2, gas)) / 200.0
        a11, a22 = c1 + slope, c2 + slope + foot
        determinant = a11 * a22 - slope * slope
        d1 = -(r1 * a22 + r2 * slope) / determinant
        d2 = -(a11 * r2 + slope * r1) / determinant
        before, part = abs(r1) + abs(r2), 1.0
        for _ in range(12):
            q1, q2 = p1 + part * d1, p2 + part * d2
            through, out = flows(plant, q1, q2, reserve, held, x, thin, valves, field)
            r1 = volume1 * stored(plant, q1, gas) - e1 + step * through
            r2 = volume2 * stored(plant, q2, gas) - e2 - step * through + step * out
            if abs(r1) + abs(r2) < before:
                break
            part *= 0.5
        p1, p2 = q1, q2
        if part * (abs(d1) + abs(d2)) < 20.0:
            break
    return p1, p2


@compiled
def integrate(plant, x_in, v_in, a_in, temperature, current, step, out):
    """Runs a drive; ``out`` (n, 4) receives force and the pressures of rebound, compression and reserve."""
    annulus = plant.piston - plant.rod
    memory = np.zeros(MEMORY)
    solid, gas_state, gel_state, valve_state = memory[0:10], memory[10:12], memory[12:16], memory[16:20]
    air, magnet, rod = memory[20:22], memory[22:26], memory[26:28]
    gas_state[0], gel_state[1], rod[0], solid[4] = 1.0, 1.0, x_in[0], x_in[0]
    p3 = gas_pressure(plant, x_in[0], temperature[0] - 30.0, gas_state, 0.0, 0.0)
    p1 = p2 = p3
    e1 = (plant.rebound_volume - annulus * x_in[0]) * stored(plant, p1, plant.free_gas)
    e2 = (plant.compression_volume + plant.piston * x_in[0]) * stored(plant, p2, plant.free_gas)
    travel, force, first = 0.0, annulus * p1 - plant.piston * p2 + plant.rod * AMBIENT, x_in[0]
    settle(plant, rod, force)
    for i in range(x_in.size):
        x, v, a = rod_motion(plant, rod, solid, x_in[i], v_in[i], a_in[i], force, step)
        thin, field = viscosity(plant, temperature[i]), magnetise(plant, magnet, current[i], step)
        gas = aerate(plant, air, min(p1, p2), v, step)
        p3 = gas_pressure(plant, x, temperature[i] - 30.0, gas_state, step, x - first)
        first = x
        held = gelled(plant, gel_state, travel, step) if plant.gel_form > 0 else 0.0
        if plant.delay_form > 0:
            lagged(plant, valve_state, p1 - p2 - held, field, step)
        v1 = plant.rebound_volume - annulus * x
        v2 = plant.compression_volume + plant.piston * x
        e1 += step * annulus * v
        e2 -= step * plant.piston * v
        p1, p2 = solve(plant, e1, e2, v1, v2, step, p1, p2, p3, held, x, thin, valve_state, field, gas)
        through, out_of_foot = flows(plant, p1, p2, p3, held, x, thin, valve_state, field)
        e1 -= step * through
        e2 += step * (through - out_of_foot)
        travel = step * through / annulus
        force = annulus * p1 - plant.piston * p2 + plant.rod * AMBIENT
        force += rubbed(plant, solid, x, v, max(p1, p2), step) + stopped(plant, x, v)
        force = rod_side(plant, solid, x, v, a, force, step)
        out[i, 0] = gauge_force(plant, rod, solid, force)
        out[i, 1], out[i, 2], out[i, 3] = p1, p2, p3
