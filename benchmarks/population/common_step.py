"""Common parts of a step of all families: the joint and the rod behind it, air in the oil, the coil's field
(compiled)."""

from math import exp, tanh

import numpy as np

from damper_estimator.compiled import compiled
from population.friction_and_stops import joint, massed
from population.plant_parameters import AMBIENT

MEMORY = 28
"""Solids 0 to 9 (friction 0 to 3, ringing mass 4, 5, joint 6, gauge 7), gas 10, gel 12, valves 16, air 20, magnet 22,
rod 26.
"""


@compiled
def rod_motion(plant, rod, solid, x_in, v_in, a_in, resisting, step):
    """Displacement, velocity and acceleration of the rod: given, or those of a mass behind a joint."""
    if plant.mount_form == 0:
        return x_in, v_in, a_in
    pull = joint(plant, solid[6:7], x_in - rod[0], v_in - rod[1], step)
    solid[7] = pull
    moving = plant.rod_mass + (plant.mass if plant.mass_form == 1 or plant.mass_form > 2 else 0.0)
    a = (pull - resisting) / moving
    rod[1] += step * a
    rod[0] += step * rod[1]
    return rod[0], rod[1], a


@compiled
def settle(plant, rod, force):
    """Moves the rod to the position where its joint balances ``force`` (N) at rest."""
    if plant.mount_form == 0:
        return
    given, scratch, deflection = rod[0], np.zeros(1), 0.0
    for _ in range(400):
        deflection += (force - joint(plant, scratch, deflection, 0.0, 1e-4)) / (4.0 * plant.mount)
    rod[0] = given - deflection


@compiled
def rod_side(plant, solid, x, v, a, force, step):
    """Force in N on the rod with its masses; behind a joint plain masses are in the rod's equation."""
    if plant.mount_form == 0:
        return force + plant.rod_mass * a + massed(plant, solid[4:6], x, v, a, step)
    if plant.mass_form == 2:
        return force + massed(plant, solid[4:6], x, v, a, step)
    if plant.mass_form > 2:
        return force + massed(plant, solid[4:6], x, v, 0.0, step)
    return force


@compiled
def gauge_force(plant, rod, solid, force):
    """The gauge's force: that of the joint, if there is one."""
    return force if plant.mount_form == 0 else solid[7]


@compiled
def aerate(plant, air, pressure, v, step):
    """Free gas in the oil, as a share: the permanent share, foam from long work, and gas released by low pressure."""
    air[0] += step * ((1.0 - air[0]) * abs(v) / 0.2 / 30.0 - air[0] / 200.0)
    if plant.release > 0.0:
        if pressure < AMBIENT:
            air[1] += step * plant.release * 0.02 * min((AMBIENT - pressure) / AMBIENT, 1.0)
        else:
            air[1] *= exp(-step * min(pressure / AMBIENT, 40.0) / 2.0)
    return plant.free_gas + plant.foam * air[0] + air[1]


@compiled
def steady_field(form, share):
    """The field at a constant current, given as a share of the saturation current."""
    if form == 2:
        return share * share / (0.3 + share * share) * 1.3
    if form == 3:
        return max(share, 0.0) ** 1.5 / (1.0 + 0.3 * max(share, 0.0))
    return tanh(share) * 1.2


@compiled
def magnetise(plant, magnet, current, step):
    """The field, 0 to about 1, of the current; constant if the current has no effect."""
    form = plant.current_form
    if form == 0:
        return plant.idle
    share = abs(current) / plant.saturation
    magnet[0] += (share - magnet[0]) * (1.0 - exp(-step / plant.coil))
    if form == 2:  # eddy currents in the core: part of the field is delayed
        magnet[1] += (magnet[0] - magnet[1]) * (1.0 - exp(-step / plant.eddy))
        return steady_field(form, 0.6 * magnet[0] + 0.4 * magnet[1])
    if form == 3:  # remanence: the field lags behind the current
        magnet[1] = min(max(magnet[1], magnet[0] - 0.12), magnet[0] + 0.12)
        return steady_field(form, magnet[1])
    return steady_field(form, magnet[0])
