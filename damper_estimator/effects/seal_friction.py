"""Seal friction: viscous at very low speed, Coulomb above, per direction.

    F = F_f v / v_s  for |v| < v_s,      F = F_f sign(v)  beyond,      v_s = 7 mm/s

F_f in N, separate in rebound and compression. No state. Source: Carrera Akutain et al., section 3 and
figure 5.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.signals.layout import V

SWITCH = Setting("switch", "m/s", 0.007, "speed above which friction is constant", lower=1e-6)


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_f clip(v / v_s, -1, 1)."""
    for i in range(force.size):
        share = kinematics[V, i] / settings[0]
        if share > 0.0:
            force[i] += parameters[0] * min(share, 1.0)
        else:
            force[i] += parameters[1] * max(share, -1.0)


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="friction",
    tests=("friction step",),
    parameters=(
        Parameter("rebound", "N", 50.0, 0.0, 10000.0, "friction force in rebound", linear=True),
        Parameter("compression", "N", 50.0, 0.0, 10000.0, "friction force in compression", linear=True),
    ),
    settings=(SWITCH,),
    shows="an odd step of the force where the velocity changes sign",
    separate="a slow triangle (5 mm/s): friction remains, viscous force vanishes",
)
