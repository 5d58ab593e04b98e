"""Magneto-rheological damper: viscous, yield and pre-yield parts all follow the field; the gap's flow is solved for."""

from math import exp

import numpy as np

from damper_estimator.compiled import compiled
from population.common_step import MEMORY, aerate, gauge_force, magnetise, rod_motion, rod_side, settle
from population.flows import blow_off, gas_pressure, gelled, orifice, placed, stored, viscosity
from population.friction_and_stops import rubbed, stopped
from population.plant_parameters import AMBIENT

LAYERS = (0.3, 1.0, 2.2)
"""Yield travels of the layers of the gap, which yield one after the other, relative to ``reach``."""


@compiled
def held_back(plant, layers, travel, yielding, reach):
    """Yield pressure in Pa after a further ``travel`` (m) of the fluid."""
    held = 0.0
    for layer in range(3):
        share = layers[layer] + travel / (reach * LAYERS[layer])
        held += min(max(share, -1.0), 1.0) / 3.0
    return yielding * held


@compiled
def bypass_flow(plant, pressure, x, thin):
    """Flow in m^3/s that bypasses the gap: leak, relief, position-dependent passages."""
    flow = pressure * plant.leak / thin
    flow += orifice(blow_off(plant, pressure), pressure, 2e3, plant.density)
    if pressure < 0.0:
        flow += orifice(plant.check_c, pressure, plant.transition, plant.density)
    return flow + orifice(placed(plant, x, pressure), pressure, plant.transition * thin * thin, plant.density)


@compiled
def solve(plant, layers, excess, volume, step, start, back, x, thin, yielding, viscous, reach, gas):
    """Flow in m^3/s through the gap that balances the oil in the rebound chamber at the end of the step."""
    annulus = plant.piston - plant.rod
    low, high, q, nudge = -0.1, 0.1, start, 1e-9
    for _ in range(80):
        left, slope = 0.0, 0.0
        for side in range(2):
            trial = q if side == 0 else q + nudge
            p = held_back(plant, layers, trial * step / annulus, yielding, reach)
            p += (viscous + plant.gap_square * abs(trial)) * trial
            flow = trial + bypass_flow(plant, p, x, thin)
            value = volume * stored(plant, p + back, gas) - excess + step * flow
            if side == 0:
                left = value
            else:
                slope = (value - left) / nudge
        if left > 0.0:
            high = q
        else:
            low = q
        moved = q - left / slope
        if moved <= low or moved >= high:
            moved = 0.5 * (low + high)
        if abs(moved - q) < 1e-9:
            return moved
        q = moved
    return q


@compiled
def integrate(plant, x_in, v_in, a_in, temperature, current, step, out):
    """Runs a drive; ``out`` (n, 4) receives force and the pressures of rebound, compression and gas."""
    annulus = plant.piston - plant.rod
    memory, layers = np.zeros(MEMORY), np.zeros(3)
    solid, gas_state, gel_state = memory[0:10], memory[10:12], memory[12:16]
    air, magnet, rod = memory[20:22], memory[22:26], memory[26:28]
    gas_state[0], gel_state[1], rod[0], solid[4] = 1.0, 1.0, x_in[0], x_in[0]
    p2 = gas_pressure(plant, x_in[0], temperature[0] - 30.0, gas_state, 0.0, 0.0)
    p1 = p2
    excess = (plant.rebound_volume - annulus * x_in[0]) * stored(plant, p1, plant.free_gas)
    travel, q, force, first = 0.0, 0.0, annulus * p1 - plant.piston * p2 + plant.rod * AMBIENT, x_in[0]
    settle(plant, rod, force)
    for i in range(x_in.size):
        x, v, a = rod_motion(plant, rod, solid, x_in[i], v_in[i], a_in[i], force, step)
        thin, field = viscosity(plant, temperature[i]), magnetise(plant, magnet, current[i], step)
        gas = aerate(plant, air, p1, v, step)
        p2 = gas_pressure(plant, x, temperature[i] - 30.0, gas_state, step, x - first)
        first = x
        held = gelled(plant, gel_state, travel, step) if plant.gel_form > 0 else 0.0
        yielding = (plant.yield_low + plant.yield_gain * field) * exp(-plant.warm_yield * (temperature[i] - 30.0))
        viscous = plant.gap * thin * (1.0 + plant.gap_gain * field)
        reach = plant.reach * (1.0 + plant.reach_gain * field)
        volume, before = plant.rebound_volume - annulus * x, excess
        excess += step * annulus * v
        back = p2 + held
        q = solve(plant, layers, excess, volume, step, q, back, x, thin, yielding, viscous, reach, gas)
        p = held_back(plant, layers, q * step / annulus, yielding, reach)
        p += (viscous + plant.gap_square * abs(q)) * q
        for layer in range(3):
            share = layers[layer] + q * step / annulus / (reach * LAYERS[layer])
            layers[layer] = min(max(share, -1.0), 1.0)
        p1 = p + back
        excess = volume * stored(plant, p1, gas)
        travel = step * v - (excess - before) / annulus
        force = annulus * p1 - plant.piston * p2 + plant.rod * AMBIENT
        force += rubbed(plant, solid, x, v, max(p1, p2), step) + stopped(plant, x, v)
        force = rod_side(plant, solid, x, v, a, force, step)
        out[i, 0] = gauge_force(plant, rod, solid, force)
        out[i, 1], out[i, 2], out[i, 3] = p1, p2, p2
