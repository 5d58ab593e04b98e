"""Starved intake: oil follows the piston only up to a speed, and the stroke back must close the void first.

    ds/dt = u - v_o  where s > 0 or u > v_o, s >= 0,      F <- F (1 - h)  on the way back while s > 0

s in m is the void, as travel; v_o in m/s the speed up to which oil follows; h without unit the share of the force on
the way back that is missing: 1 if only vapour fills the void, less if air does. Setting: side, 1 if the void opens in
rebound, below a piston that the foot valve cannot supply (u = v); -1 if it opens in compression, above one whose own
valve cannot (u = -v). States: void, last velocity; first order in the step. Source: Dixon 2008, cavitation of the foot
valve and of the piston's; the loss of force at reversal in the HIS paper, section 3.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= 1 - h on the way back while a void exists."""
    follows, missing, side = parameters[0], parameters[1], settings[0]
    for i in range(force.size):
        v, dt = kinematics[V, i], kinematics[DT, i]
        if dt <= 0.0:
            state[0] = 0.0
        else:
            state[0] = max(state[0] + dt * (0.5 * side * (v + state[1]) - follows), 0.0)
        state[1] = v
        if state[0] > 0.0 and side * force[i] < 0.0:
            force[i] *= 1.0 - missing


def trial(ranges: Ranges) -> Trial:
    """Only a speed that is exceeded is visible; on either side of the piston."""
    shares = (0.03, 0.08, 0.15, 0.25, 0.4, 0.6, 0.8)
    limits = {"follows": (0.01 * ranges.speed, ranges.speed), "missing": (0.05, 1.0)}
    values = {"follows": 0.3 * ranges.speed, "missing": 0.5}
    starts = spread(follows=tuple(share * ranges.speed for share in shares))
    return Trial(values, limits, starts, conditions=({"side": -1.0},))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="cavitation",
    tests=("history",),
    parameters=(
        Parameter("follows", "m/s", 0.3, 0.001, 10.0, "speed up to which oil follows"),
        Parameter("missing", "1", 0.9, 0.0, 1.0, "share of the force on the way back that is missing while it closes"),
    ),
    settings=(Setting("side", "1", 1.0, "1: the void opens in rebound, -1: in compression", lower=-1.0, upper=1.0),),
    states=2,
    linear=False,
    order=1,
    shows="after a fast stroke in one direction the force in the other one returns late",
    separate="repeat with higher gas pressure, or slow strokes before the same fast ones back",
    trial=trial,
)
