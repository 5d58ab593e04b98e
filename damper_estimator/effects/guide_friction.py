"""Friction of the rod's guide under a side force that changes over the stroke.

    F = F_f(x) clip(v / v_s, -1, 1)

F_f(x) in N is straight between its values at the compressed end, in the middle and at the extended end of the stroke
(the ends in m are settings), and constant beyond; v_s in m/s is a setting. The side force of a strut grows with that of
its spring, and the distance between guide and piston shrinks as the rod extends. No state. Source: statics of the rod
between guide and piston; Dixon 2008, friction of struts.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.seal_friction import SWITCH
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import V, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_f(x) clip(v / v_s, -1, 1)."""
    compressed, extended, switch = settings[0], settings[1], settings[2]
    middle, half = 0.5 * (compressed + extended), max(0.5 * (extended - compressed), 1e-6)
    for i in range(force.size):
        place = min(max((kinematics[X, i] - middle) / half, -1.0), 1.0)
        end = parameters[2] if place > 0.0 else parameters[0]
        friction = parameters[1] + abs(place) * (end - parameters[1])
        force[i] += friction * min(max(kinematics[V, i] / switch, -1.0), 1.0)


def trial(ranges: Ranges) -> Trial:
    """Between the ends of the recorded stroke."""
    return Trial({"compressed_end": ranges.compression, "extended_end": ranges.extension})


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="friction",
    tests=("friction step",),
    parameters=(
        Parameter("compressed", "N", 50.0, 0.0, 10000.0, "friction force at the compressed end", linear=True),
        Parameter("middle", "N", 20.0, 0.0, 10000.0, "friction force in the middle of the stroke", linear=True),
        Parameter("extended", "N", 20.0, 0.0, 10000.0, "friction force at the extended end", linear=True),
    ),
    settings=(
        Setting("compressed_end", "m", -0.03, "displacement of the compressed end of the stroke"),
        Setting("extended_end", "m", 0.03, "displacement of its extended end"),
        SWITCH,
    ),
    shows="an odd step of the force where the velocity changes sign, of another size in other parts of the stroke",
    separate="a slow triangle (5 mm/s) about two mean positions",
    trial=trial,
)
