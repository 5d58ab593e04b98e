"""Dry friction, joints, masses and stops: one evaluation each (compiled)."""

from math import exp, pi, sqrt, tanh

from damper_estimator.compiled import compiled
from population.plant_parameters import AMBIENT


@compiled
def rubbed(plant, state, x, v, pressure, step):
    """Dry friction in N after a step at rod velocity ``v``."""
    if plant.rub_form == 0:
        return 0.0
    strength = plant.rub + plant.rub_pressure * max(pressure - AMBIENT, 0.0)
    strength *= 1.0 + plant.rub_side * max(x, -plant.stroke) / plant.stroke
    speed = abs(v)
    if plant.rub_form == 1:  # Coulomb, proportional to the load on the seals
        return strength * v / (speed + 5e-4)
    if plant.rub_form == 2:  # Stribeck with a short elastic travel, bent rod
        reach = strength / plant.rub_stiffness
        state[0] = min(max(state[0] + v * step / reach, -1.0), 1.0)
        return strength * state[0] * (1.0 + plant.rub_extra * exp(-speed / plant.rub_speed))
    if plant.rub_form == 3:  # LuGre's bristles
        ratio = v / plant.rub_speed
        limit = strength * (1.0 + plant.rub_extra * exp(-ratio * ratio)) / plant.rub_stiffness
        before = state[0]
        state[0] = (before + step * v) / (1.0 + step * speed / limit)
        return plant.rub_stiffness * state[0] + 2.0 * sqrt(plant.rub_stiffness) * (state[0] - before) / step
    held = 0.0  # seal and band: three contacts of different reach, stronger in extension
    for contact in range(3):
        reach = strength / plant.rub_stiffness * (0.3, 1.0, 3.0)[contact]
        state[contact] = min(max(state[contact] + v * step / reach, -0.8), 1.2)
        held += state[contact] / 3.0
    return strength * held


@compiled
def joint(plant, state, deflection, rate, step):
    """Force in N of the joint between gauge and rod."""
    k = plant.mount
    if plant.mount_form == 1:  # rubber: hardens, and one relaxing branch
        branch = plant.mount_loss * k * 2.0
        relax = 0.01  # s
        state[0] = (state[0] + rate * step) / (1.0 + step / relax)
        far = deflection / 1.5e-3
        return k * deflection * (1.0 + 0.3 * far * far / (1.0 + 0.05 * far * far)) + branch * state[0]
    if plant.mount_form == 2:  # filled rubber: dry loss, relatively larger for small motions
        stiff = 2.0 * k
        yielded = 60.0 + 0.1 * k * 1e-3
        state[0] = min(max(state[0] + rate * step * stiff, -yielded), yielded)
        return k * deflection + state[0] + 0.02 * k / 60.0 * rate
    gap = plant.mount_gap  # worn bush: soft in its middle
    return k * (deflection - 0.85 * gap * tanh(deflection / gap)) + plant.mount_loss * k / 60.0 * rate


@compiled
def massed(plant, state, x, v, a, step):
    """Force in N of masses that move with the rod on the damper's side of the gauge."""
    if plant.mass_form == 2:  # held by a link that rings
        omega = 2.0 * pi * plant.mass_ring
        pull = omega * omega * (x - state[0]) + 0.3 * omega * (v - state[1])
        state[1] += step * pull
        state[0] += step * state[1]
        return plant.mass * pull
    if plant.mass_form == 3:  # moved by a lever whose ratio changes over the stroke
        ratio = 1.0 + plant.mass_lever * x / plant.stroke
        return plant.mass * ratio * (ratio * a + plant.mass_lever / plant.stroke * v * v)
    if plant.mass_form == 4:  # oil in a hose to the reservoir, with the hose's throttling
        return plant.mass * (a + 0.6 * v * abs(v) / 0.05)
    return plant.mass * a


@compiled
def stopped(plant, x, v):
    """Force in N of stops inside the stroke."""
    form = plant.stop_form
    if form == 0:
        return 0.0
    low, high = plant.stop_low - x, x - plant.stop_high
    into, sign = (low, -1.0) if low > 0.0 else (high, 1.0)
    if into <= 0.0:
        return 0.0
    rate = sign * v  # > 0 during compression of the stop
    if form == 1:  # foam that locks up, with loss
        depth = min(into / 0.035, 0.85)
        return sign * plant.stop * into / (1.0 - depth) * (1.0 + 0.25 * tanh(rate / 0.1))
    if form == 2:  # hydraulic: a plug blocks the oil
        closing = max(rate, 0.0)
        share = min(into / 0.02, 1.0)
        return sign * plant.stop * (0.05 * into + 0.08 * share * closing * (0.3 + closing))
    return sign * plant.stop * into + sign * max(0.003 * plant.stop * rate * min(into / 2e-3, 1.0), 0.0)  # steel spring
