"""Leak that grows as the oil warms up: thin oil flows past the elements that produce the force, slow motion most.

    F = F_0 + d' / (g (theta - theta_0)),      F = F_path(v - d')

g in m/(s N K) is the rise of the leak's flow, as a velocity of the piston, per newton and kelvin; theta in deg C
(measured), theta_0 in deg C and F_0 in N, the path's force at rest (settings). Laminar gaps carry a flow in proportion
to pressure over viscosity, orifices hardly notice the viscosity: the force falls where it is steep over the velocity,
and keeps its value where a valve holds it. At theta_0 and below, and without a temperature, it is closed. Solved
implicitly, second order in the step (``model.chain``). Source: laminar leakage past piston and seals, Dixon 2008.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.dashpot import FIRST
from damper_estimator.effects.oil_spring import AT_REST
from damper_estimator.effects.slow_channels import REFERENCE, reference_temperatures, with_moved_temperature
from damper_estimator.effects.trial import Ranges, Trial, Untestable, spread
from damper_estimator.signals.layout import DT, TEMPERATURE, V, X

_CLOSED = 1e-9  # m/(s N), a leak too small to be felt
_MOST = 0.5  # of the speed, that leaks


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Force over the flow V through the leak."""
    for i in range(force.size):
        if kinematics[DT, i] > 0.0:
            theta, leak = kinematics[TEMPERATURE, i], _CLOSED
            if np.isfinite(theta):
                leak = max(parameters[0] * (theta - settings[0]), _CLOSED)
            force[i] += settings[1] + kinematics[V, i] / leak
        else:
            force[i] += settings[1] + FIRST * kinematics[X, i]


def trial(ranges: Ranges) -> Trial:
    """The model holds at one temperature; only what is warmer leaks more."""
    first, *others = reference_temperatures(ranges)
    warmest = max(ranges.temperature or (first,))
    if warmest <= first:
        raise Untestable("the oil is not warmer than when the model was identified")
    most = _MOST * ranges.speed / (ranges.force * (warmest - first))
    values = {"reference": first, "at_rest": ranges.oil_at_rest, "growth": 0.1 * most}
    conditions = tuple({"reference": at} for at in others if at < warmest)
    trial = Trial(values, {"growth": (0.0, most)}, spread(growth=(0.02 * most, 0.4 * most)), conditions=conditions)
    return with_moved_temperature(trial, ranges)


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="temperature_fade",
    tests=("temperature",),
    parameters=(Parameter("growth", "m/(s N K)", 1e-6, 0.0, 1e-2, "rise of the leak per newton and kelvin"),),
    settings=(
        REFERENCE,
        AT_REST,
    ),
    order=2,
    of_oil=True,
    shows="the damping falls as the damper warms up, most at low velocity; where a valve holds the force it stays",
    separate="the same manoeuvre cold and warm, slow and fast",
    trial=trial,
)
