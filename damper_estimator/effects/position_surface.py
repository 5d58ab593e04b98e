"""Change of the force-velocity curve towards the ends of the stroke, of any form.

    F = f_e(v) s      for s > 0,        s = (x - x_0) / d, held at -1 and 1
    F = -f_c(v) s     for s < 0

f_e in N is the change at the extended end, f_c that at the compressed end, each with its curves for rebound and
compression: zero at rest, straight between their knots, held beyond the last. Settings: knots in m/s, rising; x_0 in m
(where the model holds), d in m (from there to the ends). No state. Source: form-free counterpart of grooves, ports and
metering pins, e.g. Lee and Moon 2005; surfaces of force over velocity and displacement, Worden and Tomlinson 2001.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.direction_curve import over_speed
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import V, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += |s| f(v), with the curves of the end on the side of s."""
    count = settings.size - 2
    middle, reach = settings[count], settings[count + 1]
    for i in range(force.size):
        v = kinematics[V, i]
        share = min(max((kinematics[X, i] - middle) / reach, -1.0), 1.0)
        first = 0 if share > 0.0 else 2 * count
        if v < 0.0:
            first += count
        force[i] += abs(share) * over_speed(
            settings, parameters[first : first + count], min(abs(v), settings[count - 1])
        )


def trial(ranges: Ranges) -> Trial:
    """Knots over the recorded speeds; the model holds in the middle of the stroke, or towards one end."""
    half = max(0.5 * ranges.stroke, 1e-3)
    knots = tuple(share * ranges.speed for share in (0.12, 0.4, 1.0))
    places = tuple({"middle": ranges.middle + side * 0.5 * half} for side in (-1.0, 1.0))
    return Trial({"speed": knots, "middle": ranges.middle, "reach": half}, conditions=places)


_TABLE = ("N", 0.0, -50000.0, 50000.0)

EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="position_dependence",
    tests=("position",),
    parameters=(
        Parameter("extended_rebound", *_TABLE, "change at the extended end in rebound", linear=True, size="speed"),
        Parameter("extended_compression", *_TABLE, "the same in compression", linear=True, size="speed"),
        Parameter("compressed_rebound", *_TABLE, "change at the compressed end in rebound", linear=True, size="speed"),
        Parameter("compressed_compression", *_TABLE, "the same in compression", linear=True, size="speed"),
    ),
    settings=(
        Setting("speed", "m/s", (0.05, 0.2, 0.5), "knots over the speed", lower=1e-6, increasing=True),
        Setting("middle", "m", 0.0, "position at which the model holds"),
        Setting("reach", "m", 0.05, "from there to the ends", lower=1e-4),
    ),
    shows="at the same velocity the force differs between parts of the stroke",
    separate="the same velocities at several mean positions",
    trial=trial,
    general=True,
)
