"""The damper's differential equations and their step (compiled).

States u, in the order of the constants below:

    g' = A_reb v - Q                oil compressed into the rebound chamber, m^3
    c' = A_com v + A w - Q          volume that opens in the compression chamber, m^3
    w' = (A (p_com - p_gas) - seal) / m     floating piston's velocity, m/s
    a' = (lift(p) - a) / T          discs' areas, rebound and compression, m^2; only with a lift time
    x', v'                          rod below the mount; only with a mount

with p_reb and p_com from g and c and the volumes at x, and the floating piston's position (c - g - A_rod x) / A. Oil is
conserved: the oil that leaves one chamber enters the other. The sliders of dry elements and the temperature are
constant during a step and updated after it.

Step: the two-stage Rosenbrock method ROS2 with gamma = 1 - 1/sqrt(2), second order (also with an approximate Jacobian)
and L-stable; a step is divided if the oil's motion is too fast for it. J. G. Verwer et al., A second-order Rosenbrock
method applied to photochemical dispersion problems, SIAM J. Sci. Comput. 20 (1999).
"""

from math import exp, sqrt, tanh

from damper_estimator.compiled import compiled
from damper_estimator.plant.hydraulics import gas_pressure, lift_area, liquid_pressure, piston_flow
from damper_estimator.plant.parts import AMBIENT_PRESSURE, ZERO_CELSIUS
from damper_estimator.plant.solids import (
    ELEMENTS,
    drag_sliders,
    mount_force,
    seal_strength,
    stack_share,
    stop_force,
)

PACKED, OPENED, FLOATING, REBOUND_AREA, COMPRESSION_AREA, ROD, ROD_VELOCITY = range(7)
TEMPERATURE, FIELD, POWER, SEAL = 7, 8, 9, 10
GEL, COIL = SEAL + ELEMENTS, SEAL + 2 * ELEMENTS
MEMORY_SIZE = SEAL + 3 * ELEMENTS
"""The memory of a damper: seven states, oil temperature, coil's field (A), dissipated power (W), sliders."""

WORK_ROWS, MOVED = 12, 8
"""Rows of scratch space, 7 wide: Jacobian, then vectors, one of them the states after a trial step."""

ROUGHNESS = 4e4
"""Pa, difference between first and second order at a step of 0.1 ms beyond which the step is divided."""

FORCE, REBOUND_PRESSURE, COMPRESSION_PRESSURE, GAS_PRESSURE, OUT_TEMPERATURE, FLOAT, OUT_ROD, OUT_FIELD = range(8)
OUT_ROWS = 8

_GAMMA = 1.0 - 1.0 / sqrt(2.0)
_CREEP = 2e-3  # m/s, width over which the floating piston's dry friction changes sign


@compiled
def state_count(parts):
    """Number of active states: 3, 5 with a lift time, 7 with a mount."""
    if parts.mount.stiffness > 0.0:
        return 7
    return 5 if parts.piston.lift_time > 0.0 else 3


@compiled
def pressures(parts, memory, u, x):
    """Pressures (Pa) of rebound chamber, compression chamber and gas, and the floating piston's position (m)."""
    chambers = parts.chambers
    rod_volume = (chambers.compression_area - chambers.rebound_area) * x
    float_volume = u[OPENED] - u[PACKED] - rod_volume
    rebound_volume = chambers.rebound_volume - chambers.rebound_area * x
    compression_volume = chambers.compression_volume + chambers.compression_area * x + float_volume
    rebound = liquid_pressure(parts.oil, chambers.rebound_excess + u[PACKED], rebound_volume)
    compression = liquid_pressure(parts.oil, chambers.compression_excess - u[OPENED], compression_volume)
    warmth = (memory[TEMPERATURE] + ZERO_CELSIUS) / (parts.heat.start + ZERO_CELSIUS)
    gas = gas_pressure(parts.gas, chambers.gas_volume, float_volume, warmth)
    return rebound, compression, gas, float_volume / chambers.piston_area


@compiled
def yield_pressure(parts, memory, u, x):
    """Yield pressure in Pa of gelled oil and the coil's field; elastic over the oil's travel until it yields."""
    gel, coil, held = parts.gel, parts.coil, 0.0
    travel = x - u[PACKED] / parts.chambers.rebound_area
    if gel.pressure > 0.0:
        held += gel.pressure * stack_share(travel, memory, GEL, gel.reach)
    if coil.pressure > 0.0:
        strength = memory[FIELD] / (memory[FIELD] + coil.saturation)
        held += coil.pressure * strength * stack_share(travel, memory, COIL, coil.reach)
    return held


@compiled
def lifted(parts, u, pressure):
    """Areas in m^2 of the rebound and compression discs: immediate, or the lagging states."""
    if parts.piston.lift_time > 0.0:
        return u[REBOUND_AREA], u[COMPRESSION_AREA]
    return lift_area(parts.rebound, pressure), lift_area(parts.compression, -pressure)


@compiled
def seal_force(parts, memory, rebound_pressure, x, v):
    """Friction in N of rod seal and piston band."""
    seal = parts.seal
    strength = seal_strength(seal, rebound_pressure, v)
    return strength * stack_share(x, memory, SEAL, seal.reach) + seal.viscous * v


@compiled
def rod_force(parts, memory, rebound, compression, x, v):
    """Force in N on the rod, positive where it resists extension: pressures, seals, stops."""
    chambers = parts.chambers
    force = chambers.rebound_area * (rebound - AMBIENT_PRESSURE)
    force -= chambers.compression_area * (compression - AMBIENT_PRESSURE)
    return force + seal_force(parts, memory, rebound, x, v) + stop_force(parts.stops, x, v)


@compiled
def through_piston(parts, memory, u, rebound, compression, x):
    """Flow in m^3/s from rebound to compression chamber, and the pressure in Pa at the valves."""
    viscosity = exp(-parts.oil.viscosity_slope * (memory[TEMPERATURE] - 40.0))
    driving = rebound - compression - yield_pressure(parts, memory, u, x)
    rebound_area, compression_area = lifted(parts, u, driving)
    return piston_flow(parts, rebound_area, compression_area, driving, x, viscosity), driving


@compiled
def slopes(parts, memory, u, given_x, given_v, out):
    """Time derivatives of the states at the prescribed displacement and velocity; written to ``out``."""
    mounted = parts.mount.stiffness > 0.0
    x = u[ROD] if mounted else given_x
    v = u[ROD_VELOCITY] if mounted else given_v
    chambers, gas = parts.chambers, parts.gas
    rebound, compression, charge, _ = pressures(parts, memory, u, x)
    flow, driving = through_piston(parts, memory, u, rebound, compression, x)
    out[PACKED] = chambers.rebound_area * v - flow
    out[OPENED] = chambers.compression_area * v + chambers.piston_area * u[FLOATING] - flow
    drag = gas.piston_damping * u[FLOATING] + gas.piston_friction * tanh(u[FLOATING] / _CREEP)
    out[FLOATING] = (chambers.piston_area * (compression - charge) - drag) / gas.piston_mass
    out[REBOUND_AREA] = out[COMPRESSION_AREA] = 0.0
    if parts.piston.lift_time > 0.0:
        out[REBOUND_AREA] = (lift_area(parts.rebound, driving) - u[REBOUND_AREA]) / parts.piston.lift_time
        out[COMPRESSION_AREA] = (lift_area(parts.compression, -driving) - u[COMPRESSION_AREA]) / parts.piston.lift_time
    if mounted:
        pull = mount_force(parts.mount, given_x - x, given_v - v)
        out[ROD] = v
        resisting = rod_force(parts, memory, rebound, compression, x, v)
        out[ROD_VELOCITY] = (pull - resisting) / (parts.mount.rod_mass + parts.inertia)


@compiled
def nudge(parts, number):
    """Difference step of a state for the Jacobian: about 1 kPa, 10 um/s, 0.01 mm^2, 10 nm, 10 um/s."""
    if number == PACKED:
        return 1e3 * parts.chambers.rebound_volume / parts.oil.bulk_modulus
    if number == OPENED:
        return 1e3 * parts.chambers.compression_volume / parts.oil.bulk_modulus
    if number == REBOUND_AREA or number == COMPRESSION_AREA:
        return 1e-8
    return 1e-8 if number == ROD else 1e-5


@compiled
def factor(matrix, count):
    """LU factors in place, without pivots: every state is self-damped, so the diagonal of I - gamma h J stays
    positive."""
    for column in range(count):
        for row in range(column + 1, count):
            matrix[row, column] /= matrix[column, column]
            for other in range(column + 1, count):
                matrix[row, other] -= matrix[row, column] * matrix[column, other]


@compiled
def solve(matrix, vector, count):
    """Solves in place with these factors."""
    for row in range(1, count):
        for column in range(row):
            vector[row] -= matrix[row, column] * vector[column]
    for row in range(count - 1, -1, -1):
        for column in range(row + 1, count):
            vector[row] -= matrix[row, column] * vector[column]
        vector[row] /= matrix[row, row]


@compiled
def try_step(parts, memory, work, x0, v0, x1, v1, step):
    """One Rosenbrock step from (x0, v0) to (x1, v1): the new states are in ``work[MOVED]``.

    Returns the larger difference of both chambers to the first stage alone, in Pa of compressed oil.
    """
    count = state_count(parts)
    u = memory
    slope, moved, first, second, push = work[7], work[MOVED], work[9], work[10], work[11]
    slopes(parts, memory, u, x0, v0, slope)
    for column in range(7):
        moved[column] = u[column]
    for column in range(count):
        change = nudge(parts, column)
        moved[column] = u[column] + change
        slopes(parts, memory, moved, x0, v0, second)
        moved[column] = u[column]
        for row in range(count):
            work[row, column] = -_GAMMA * step * (second[row] - slope[row]) / change
        work[column, column] += 1.0
    factor(work, count)
    slopes(parts, memory, u, x1, v1, second)
    for row in range(count):
        push[row] = _GAMMA * (second[row] - slope[row])  # gamma h df/dt
        first[row] = slope[row] + push[row]
    solve(work, first, count)
    for row in range(count):
        moved[row] = u[row] + step * first[row]
    slopes(parts, memory, moved, x1, v1, second)
    for row in range(count):
        second[row] -= 2.0 * first[row] + push[row]
    solve(work, second, count)
    for row in range(count):
        moved[row] = u[row] + step * (1.5 * first[row] + 0.5 * second[row])
    packed = abs(first[PACKED] + second[PACKED]) / parts.chambers.rebound_volume
    opened = abs(first[OPENED] + second[OPENED]) / parts.chambers.compression_volume
    return 0.5 * step * parts.oil.bulk_modulus * max(packed, opened)


@compiled
def move(parts, memory, work, x0, v0, x1, v1, step):
    """Advances the states, in fractions of the step if a void opens or closes or a valve cracks too fast for it.

    Between the ends the displacement is the cubic through both displacements and velocities. The limit falls with the
    square of the step, which preserves the method's order.
    """
    limit = ROUGHNESS * min(step / 1e-4, 1.0) ** 2
    done, share = 0.0, 1.0
    xa, va = x0, v0
    while done < 1.0:
        share = min(share, 1.0 - done)
        s = done + share
        bend, twist = v0 * step - (x1 - x0), v1 * step - (x1 - x0)
        xb = x0 + s * (x1 - x0) + s * (1.0 - s) * ((1.0 - s) * bend - s * twist)
        vb = (x1 - x0 + (1.0 - s) * (1.0 - 3.0 * s) * bend + s * (3.0 * s - 2.0) * twist) / step
        change = try_step(parts, memory, work, xa, va, xb, vb, step * share)
        if change > limit and share > 1e-3:
            share *= 0.5
            continue
        for row in range(7):
            memory[row] = work[MOVED, row]
        done, xa, va, share = s, xb, vb, 2.0 * share


@compiled
def advance(parts, memory, work, x0, v0, x1, v1, current, step, out):
    """One step: advances states, sliders, field and temperature; writes force and pressures at its end to ``out``."""
    if parts.coil.pressure > 0.0:
        memory[FIELD] += (1.0 - exp(-step / parts.coil.time)) * (abs(current) - memory[FIELD])
    move(parts, memory, work, x0, v0, x1, v1, step)
    power = observe(parts, memory, x1, v1, out)
    heat = parts.heat
    mean_power = 0.5 * (power + memory[POWER])
    cooled = heat.cooling * (memory[TEMPERATURE] - heat.ambient)
    memory[TEMPERATURE] += step * (heat.heating * mean_power - cooled)
    memory[POWER] = power
    x = memory[ROD] if parts.mount.stiffness > 0.0 else x1
    travel = x - memory[PACKED] / parts.chambers.rebound_area
    drag_sliders(x, memory, SEAL, parts.seal.reach)
    drag_sliders(travel, memory, GEL, parts.gel.reach)
    drag_sliders(travel, memory, COIL, parts.coil.reach)


@compiled
def observe(parts, memory, given_x, given_v, out):
    """Writes force, pressures, temperature, floating piston, rod and field to ``out``; returns the dissipated power in
    W."""
    mounted = parts.mount.stiffness > 0.0
    x = memory[ROD] if mounted else given_x
    v = memory[ROD_VELOCITY] if mounted else given_v
    rebound, compression, gas, place = pressures(parts, memory, memory, x)
    force = rod_force(parts, memory, rebound, compression, x, v)
    flow, _ = through_piston(parts, memory, memory, rebound, compression, x)
    out[FORCE] = mount_force(parts.mount, given_x - x, given_v - v) if mounted else force
    out[REBOUND_PRESSURE], out[COMPRESSION_PRESSURE], out[GAS_PRESSURE] = rebound, compression, gas
    out[OUT_TEMPERATURE], out[FLOAT], out[OUT_ROD], out[OUT_FIELD] = memory[TEMPERATURE], place, x, memory[FIELD]
    return abs(flow * (rebound - compression)) + abs(seal_force(parts, memory, rebound, x, v) * v)


@compiled
def integrate(parts, memory, work, displacement, velocity, current, step, out):
    """Runs the whole record; ``out`` (n, OUT_ROWS) receives one row per sample, the first from the state at rest."""
    observe(parts, memory, displacement[0], velocity[0], out[0])
    for index in range(1, len(displacement)):
        before = index - 1
        advance(
            parts, memory, work, displacement[before], velocity[before], displacement[index], velocity[index],
            current[index], step, out[index],
        )  # fmt: skip
