"""Starved intake: in rebound the foot valve lets oil follow only up to a speed, and compression must close the void.

    ds/dt = v - v_o  where s > 0 or v > v_o, s >= 0,      F <- F (1 - h)  for F < 0 while s > 0

s in m is the void below the piston, as travel; v_o in m/s the speed up to which oil follows; h without unit the share
of the compression force that is missing: 1 if only vapour fills the void, less if air does. States: void, last
velocity; first order in the step. Source: Dixon 2008, cavitation of the foot valve; the loss of force at reversal in
the HIS paper, section 3.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= 1 - h in compression while a void exists."""
    follows, missing = parameters[0], parameters[1]
    for i in range(force.size):
        v, dt = kinematics[V, i], kinematics[DT, i]
        if dt <= 0.0:
            state[0] = 0.0
        else:
            state[0] = max(state[0] + dt * (0.5 * (v + state[1]) - follows), 0.0)
        state[1] = v
        if state[0] > 0.0 and force[i] < 0.0:
            force[i] *= 1.0 - missing


def trial(ranges: Ranges) -> Trial:
    """Only a speed that is exceeded is visible."""
    shares = (0.03, 0.08, 0.15, 0.25, 0.4, 0.6, 0.8)
    limits = {"follows": (0.01 * ranges.speed, ranges.speed), "missing": (0.05, 1.0)}
    values = {"follows": 0.3 * ranges.speed, "missing": 0.5}
    return Trial(values, limits, spread(follows=tuple(share * ranges.speed for share in shares)))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="cavitation",
    tests=("history",),
    parameters=(
        Parameter("follows", "m/s", 0.3, 0.001, 10.0, "rebound speed up to which oil follows"),
        Parameter("missing", "1", 0.9, 0.0, 1.0, "share of the compression force that is missing while a void exists"),
    ),
    states=2,
    linear=False,
    order=1,
    shows="after fast rebound the compression force returns late",
    separate="repeat with higher gas pressure, or slow rebound strokes before the same compression",
    trial=trial,
)
