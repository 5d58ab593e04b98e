"""LuGre friction: bristles that bend and slip, with the Stribeck effect.

    F = sigma_0 z + sigma_1 z' + sigma_2 v,      z' = v - sigma_0 |v| z / g(v)
    g(v) = F_c + (F_s - F_c) exp(-(v / v_s)^2)

sigma_0 in N/m, sigma_1, sigma_2 in N s/m, F_c, F_s in N, v_s in m/s. z is exact (an exponential) for a constant v over
a step. One state, z; first order in the step. Source: Canudas de Wit et al. 1995.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.signals.layout import DT, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += sigma_0 z + sigma_1 z' + sigma_2 v."""
    coulomb, excess, stiffness = parameters[0], parameters[1], parameters[2]
    for i in range(force.size):
        v, dt = kinematics[V, i], kinematics[DT, i]
        if dt <= 0.0:
            state[0] = 0.0
        ratio = v / settings[0]
        level = max(coulomb + excess * exp(-ratio * ratio), 1e-9)
        rate = stiffness * abs(v) / level
        steady = level / stiffness * (1.0 if v > 0.0 else -1.0)
        if rate > 0.0:
            state[0] = steady + (state[0] - steady) * exp(-rate * dt)
        change = v - rate * state[0]
        force[i] += stiffness * state[0] + parameters[3] * change + parameters[4] * v


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="friction",
    tests=("friction step",),
    parameters=(
        Parameter("force", "N", 50.0, 0.0, 10000.0, "Coulomb friction F_c"),
        Parameter("excess", "N", 10.0, 0.0, 5000.0, "static friction above Coulomb's, F_s - F_c"),
        Parameter("stiffness", "N/m", 1e5, 1e3, 1e8, "stiffness of the bristles"),
        Parameter("micro_damping", "N s/m", 0.0, 0.0, 1e4, "damping of the bristles"),
        Parameter("viscous", "N s/m", 0.0, 0.0, 2e4, "viscous friction"),
    ),
    settings=(Setting("stribeck_velocity", "m/s", 0.01, "velocity beyond which static friction fades", lower=1e-5),),
    states=1,
    order=1,
    shows="an odd step at each reversal with a small peak before sliding",
    separate="a slow triangle: friction remains, viscous force vanishes",
    trial=None,
)
