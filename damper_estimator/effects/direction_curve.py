"""Difference between rebound and compression: a change of one direction, or opposite changes of both.

    F = f(|v|) (1 + s sgn v),      f straight between its knots, zero at rest, straight beyond the last

Settings: knots in m/s, rising. Parameters: f in N per knot, and s without unit: at 1 only rebound changes (a valve or a
passage of that direction), at -1 only compression; at 0 rebound becomes harder by as much as compression becomes softer
(the reverse for negative f). No state. Source: even part of a force-velocity curve, plus the odd part of a change in
one direction; bump and rebound differ by up to three to one (Dixon 2008).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import V


@compiled
def over_speed(knots, forces, speed):
    """Force in N at a speed in m/s >= 0: zero at rest, straight between the knots and beyond the last."""
    low, below = 0.0, 0.0
    k = 0
    while k < forces.size - 1 and speed > knots[k]:
        low, below = knots[k], forces[k]
        k += 1
    return below + (forces[k] - below) * (speed - low) / (knots[k] - low)


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += f(|v|) (1 + s sgn v)."""
    count = parameters.size - 1
    for i in range(force.size):
        v = kinematics[V, i]
        weight = 1.0 + parameters[count] if v > 0.0 else 1.0 - parameters[count]
        force[i] += weight * over_speed(settings, parameters[:count], abs(v))


def trial(ranges: Ranges) -> Trial:
    """Knots over the recorded speeds; either direction, or both."""
    knots = tuple(share * ranges.speed for share in (0.08, 0.25, 0.5, 1.0))
    return Trial({"speed": knots}, starts=spread(side=(-0.9, 0.9)))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="asymmetry",
    tests=("even", "rebound", "compression"),
    parameters=(
        Parameter("force", "N", 0.0, -20000.0, 20000.0, "force at the knot", linear=True, size="speed"),
        Parameter("side", "1", 0.0, -1.0, 1.0, "1: only rebound changes, -1: only compression, 0: both, oppositely"),
    ),
    settings=(Setting("speed", "m/s", (0.05, 0.2, 0.5, 1.0), "knots over the speed", lower=1e-6, increasing=True),),
    shows="the error grows with speed in one direction only, or has the same sign in rebound and compression",
    separate="constant speeds in both directions",
    trial=trial,
)
