"""Bouc-Wen hysteresis over a shifted velocity, for loops that cross near zero velocity.

    F = alpha z,      z' = (delta - (beta + gamma sgn(z w)) |z|^n) w,      w = v - mu sgn(v)

mu in m/s; the other symbols as in ``bouc_wen``. Over a step the shifted displacement is dx - mu sgn(dx) dt. States: z
and the last displacement; first order in the step, from the jump of w where v changes sign. Source: Gao et
al., eqs. (4), (5); Kwok et al. 2007.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.bouc_wen import PARAMETERS, moved, saturation
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import DT, X


@compiled
def shifted(z, move, dt, saturated, parameters):
    """z after a displacement ``move`` in the time ``dt``; parameters as declared here, ``saturated`` of them."""
    shift = parameters[5] * dt
    move -= shift if move > 0.0 else -shift
    return moved(z, move, saturated, parameters[1], parameters[2], parameters[3], parameters[4])


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += alpha z."""
    saturated = saturation(parameters[1], parameters[2], parameters[3], parameters[4])
    for i in range(force.size):
        x, dt = kinematics[X, i], kinematics[DT, i]
        if dt <= 0.0:
            state[0] = 0.0
        else:
            state[0] = shifted(state[0], x - state[1], dt, saturated, parameters)
        state[1] = x
        force[i] += parameters[0] * state[0]


SHIFTED_PARAMETERS = (*PARAMETERS, Parameter("mu", "m/s", 0.0, 0.0, 0.01, "shift of the velocity"))

EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    parameters=SHIFTED_PARAMETERS,
    states=2,
    order=1,
    shows="F-v loops whose branches cross near zero velocity",
    separate="the same amplitude at two frequencies: this hysteresis hardly changes",
    trial=None,
)
