"""Monotube damper: rebound chamber over a floating piston; one pressure to solve for at each step (compiled)."""

import numpy as np

from damper_estimator.compiled import compiled
from population.common_step import MEMORY, aerate, gauge_force, magnetise, rod_motion, rod_side, settle
from population.flows import gas_pressure, gelled, lagged, stored, through_piston, valve_areas, viscosity
from population.friction_and_stops import rubbed, stopped
from population.plant_parameters import AMBIENT


@compiled
def solve(plant, excess, volume, step, start, back, x, thin, area_r, area_c, field, gas):
    """Rebound pressure in Pa that balances the oil in the chamber at the end of the step."""
    late = plant.delay_form > 0
    low, high, p = -5e8, 5e8, start
    for _ in range(60):
        left, slope = 0.0, 0.0
        for side in range(2):
            trial = p if side == 0 else p + 200.0
            if not late:
                area_r, area_c = valve_areas(plant, trial - back, field)
            flow = through_piston(plant, trial - back, x, thin, area_r, area_c, field)
            value = volume * stored(plant, trial, gas) - excess + step * flow
            if side == 0:
                left = value
            else:
                slope = (value - left) / 200.0
        if left > 0.0:
            high = p
        else:
            low = p
        moved = p - left / slope
        if moved <= low or moved >= high:
            moved = 0.5 * (low + high)
        if abs(moved - p) < 10.0:
            return moved
        p = moved
    return p


@compiled
def integrate(plant, x_in, v_in, a_in, temperature, current, step, out):
    """Runs a drive; ``out`` (n, 4) receives force and the pressures of rebound, compression and gas."""
    annulus = plant.piston - plant.rod
    memory = np.zeros(MEMORY)
    solid, gas_state, gel_state, valve_state = memory[0:10], memory[10:12], memory[12:16], memory[16:20]
    air, magnet, rod = memory[20:22], memory[22:26], memory[26:28]
    gas_state[0], gel_state[1], rod[0], solid[4] = 1.0, 1.0, x_in[0], x_in[0]
    p2 = gas_pressure(plant, x_in[0], temperature[0] - 30.0, gas_state, 0.0, 0.0)
    p1 = p2
    excess = (plant.rebound_volume - annulus * x_in[0]) * stored(plant, p1, plant.free_gas)
    travel, force, first = 0.0, annulus * p1 - plant.piston * p2 + plant.rod * AMBIENT, x_in[0]
    settle(plant, rod, force)
    for i in range(x_in.size):
        x, v, a = rod_motion(plant, rod, solid, x_in[i], v_in[i], a_in[i], force, step)
        thin, field = viscosity(plant, temperature[i]), magnetise(plant, magnet, current[i], step)
        gas = aerate(plant, air, p1, v, step)
        p2 = gas_pressure(plant, x, temperature[i] - 30.0, gas_state, step, x - first)
        first = x
        held = gelled(plant, gel_state, travel, step) if plant.gel_form > 0 else 0.0
        volume = plant.rebound_volume - annulus * x
        if plant.delay_form > 0:
            lagged(plant, valve_state, p1 - p2 - held, field, step)
        before, back = excess, p2 + held
        excess += step * annulus * v
        p1 = solve(plant, excess, volume, step, p1, back, x, thin, valve_state[0], valve_state[2], field, gas)
        travel = step * v - (volume * stored(plant, p1, gas) - before) / annulus
        excess = volume * stored(plant, p1, gas)
        force = annulus * p1 - plant.piston * p2 + plant.rod * AMBIENT
        force += rubbed(plant, solid, x, v, max(p1, p2), step) + stopped(plant, x, v)
        force = rod_side(plant, solid, x, v, a, force, step)
        out[i, 0] = gauge_force(plant, rod, solid, force)
        out[i, 1], out[i, 2], out[i, 3] = p1, p2, p2
