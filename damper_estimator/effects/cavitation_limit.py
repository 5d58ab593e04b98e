"""Cavitation: the suction side cannot pull below vapour pressure, and the void must be refilled before force returns.

    F <- max(F, -F_cav) in compression,      F = 0 until the void, the way lost while limited, is closed again

F_cav in N. The void grows by the share of the way that the limited force does not resist, (1 - F_cav / |F|)
|dx|, and closes with the way of the opposite direction, during which the force is reduced by the share r.
States: void and last displacement; first order. Source: Dixon 2008; the loss of force at reversal in the HIS
paper, section 3.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import DT, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Limits compression force and pays the void back in rebound."""
    limit, loss = parameters[0], parameters[1]
    for i in range(force.size):
        x = kinematics[X, i]
        if kinematics[DT, i] <= 0.0:
            state[0] = 0.0
            state[1] = x
        move = x - state[1]
        state[1] = x
        if force[i] < -limit and move < 0.0:
            state[0] += (1.0 + limit / force[i]) * -move
            force[i] = -limit
        elif move > 0.0 and state[0] > 0.0:
            state[0] -= min(state[0], move)
            if force[i] > 0.0:
                force[i] *= 1.0 - loss


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="cavitation",
    parameters=(
        Parameter("limit", "N", 1000.0, 10.0, 50000.0, "compression force beyond which the oil cavitates"),
        Parameter("loss", "1", 0.8, 0.0, 1.0, "share of the rebound force that is lost while the void is refilled"),
    ),
    states=2,
    linear=False,
    order=1,
    shows="compression force is cut at a level; after the reversal rebound force comes late",
    separate="repeat with higher gas pressure: the limit moves with it",
)
