"""Friction that falls from its static to its sliding value with speed.

    F = (F_c + F_e exp(-(v / v_s)^2)) tanh(v / v_t)

F_c, F_e in N, v_s in m/s (Stribeck velocity), v_t in m/s (width through zero). No state. Source: Stribeck
1902; Armstrong-Helouvry 1994.
"""

from math import exp, tanh

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += (F_c + F_e exp(-(v / v_s)^2)) tanh(v / v_t)."""
    for i in range(force.size):
        v = kinematics[V, i]
        ratio = v / settings[0]
        force[i] += (parameters[0] + parameters[1] * exp(-ratio * ratio)) * tanh(v / settings[1])


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="friction",
    tests=("friction step",),
    parameters=(
        Parameter("force", "N", 50.0, 0.0, 10000.0, "sliding friction", linear=True),
        Parameter("excess", "N", 20.0, 0.0, 5000.0, "excess of static over sliding friction", linear=True),
    ),
    settings=(
        Setting("stribeck_velocity", "m/s", 0.02, "velocity beyond which static friction fades", lower=1e-4),
        Setting("transition", "m/s", 0.003, "width of the transition through zero velocity", lower=1e-6),
    ),
    shows="an odd step at zero velocity that is higher at very low speed",
    separate="slow triangles at several speeds below 20 mm/s",
)
