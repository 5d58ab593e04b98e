"""Cavitation: the suction side cannot pull below vapour pressure, and the void must be filled before force returns.

    F <- -F_cav while a void s > 0 exists,      ds/dt = -v - v_cav,      v_cav the speed at which F passed -F_cav

F_cav in N, s in m of piston travel, positive v in extension. A void opens where compression requires more than F_cav:
the piston then outruns oil that flows in at most at v_cav. The void closes after the piston slows down or reverses;
until then the force stays constant. A share h of the difference is cut off: 1 if only vapour fills the void, less if
air does. States: void, last displacement, v_cav, last force and speed; first order in the step. Source: Dixon 2008; the
loss of force at reversal in the HIS paper, section 3.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT, V, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Keeps the force at the limit while a void exists."""
    limit, held = parameters[0], parameters[1]
    for i in range(force.size):
        x, dt = kinematics[X, i], kinematics[DT, i]
        if dt <= 0.0:
            state[0] = 0.0
            state[1], state[3], state[4] = x, force[i], kinematics[V, i]
        move = x - state[1]
        if state[0] <= 0.0 and force[i] < -limit and move < 0.0:
            share = (limit + state[3]) / (state[3] - force[i]) if state[3] > -limit else 1.0
            state[2] = max(-state[4] - share * (kinematics[V, i] - state[4]), 0.0)
            state[0] = 1e-12
        elif state[0] > 0.0:
            state[0] = max(state[0] - move - state[2] * dt, 0.0)
        state[1], state[3], state[4] = x, force[i], kinematics[V, i]
        if state[0] > 0.0:
            force[i] -= held * (limit + force[i])


def trial(ranges: Ranges) -> Trial:
    """Only a level that is reached is visible; the error falls only near the right level, hence the narrow steps."""
    levels = tuple(0.6 * 1.12**step * ranges.force for step in range(14))
    limits = {"limit": (max(0.2 * ranges.force, 10.0), 6.0 * ranges.force), "held": (0.2, 1.0)}
    return Trial({"limit": 0.4 * ranges.force, "held": 0.9}, limits, spread(limit=levels))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="cavitation",
    tests=("history",),
    parameters=(
        Parameter("limit", "N", 1000.0, 10.0, 50000.0, "compression force at which the oil cavitates"),
        Parameter("held", "1", 0.9, 0.0, 1.0, "share of the difference that is cut off while a void exists"),
    ),
    states=5,
    linear=False,
    order=1,
    shows="compression force is cut off at a level and stays there beyond the reversal; rebound force rises late",
    separate="repeat with higher gas pressure: the limit rises with it",
    trial=trial,
)
