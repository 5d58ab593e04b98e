"""Difference between rebound and compression: a force that is the same at v and at -v.

    F = f(|v|),      f straight between its knots, zero at rest, straight beyond the last

Settings: knots in m/s, rising. Parameters: f in N per knot. Half of it makes rebound harder than the mean of both
directions, half makes compression softer (or the other way round where it is negative). No state. Source: even part
of a force-velocity curve; bump and rebound differ by up to three to one (Dixon 2008).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += f(|v|)."""
    count = parameters.size
    for i in range(force.size):
        speed = abs(kinematics[V, i])
        low, below = 0.0, 0.0
        k = 0
        while k < count - 1 and speed > settings[k]:
            low, below = settings[k], parameters[k]
            k += 1
        force[i] += below + (parameters[k] - below) * (speed - low) / (settings[k] - low)


def trial(ranges: Ranges) -> Trial:
    """Knots over the speeds that were driven."""
    return Trial({"speed": tuple(share * ranges.speed for share in (0.12, 0.4, 1.0))})


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="asymmetry",
    parameters=(Parameter("force", "N", 0.0, -20000.0, 20000.0, "force at the knot", linear=True, size="speed"),),
    settings=(Setting("speed", "m/s", (0.05, 0.2, 0.5, 1.0), "knots over the speed", lower=1e-4, increasing=True),),
    shows="at the same speed the error has the same sign in rebound and compression, and grows with speed",
    separate="constant speeds in both directions",
    trial=trial,
)
