"""Play and stiffness of a joint in series with the damper: lost motion at each reversal of the force.

    F = k (|d| - g / 2) sgn(d)  beyond the play,      F = k_0 d  within it,      F = F_path(v - d')

k in N/m, g in m the total play, d in m. k_0 = k / 1000 keeps the joint's position defined within the play. Solved
implicitly (``model.chain``); first order in the step where the force has a kink. Source: dead zone in series; the lost
motion at the reversals of bench recordings.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import X

_LOOSE = 1e-3


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Force of the joint over its deflection, row X."""
    stiffness, half = parameters[0], 0.5 * parameters[1]
    for i in range(force.size):
        d = kinematics[X, i]
        inside = min(max(d, -half), half)
        force[i] += stiffness * (d - inside + _LOOSE * inside)


def trial(ranges: Ranges) -> Trial:
    """Play is a small part of the stroke."""
    least = ranges.least_stiffness
    play = min(0.05 * ranges.stroke, 5e-3)
    limits = {"stiffness": (least, 1e9), "play": (0.0, play)}
    return Trial({"stiffness": 10.0 * least, "play": 0.2 * play}, limits, spread(play=(0.05 * play, 0.5 * play)))


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="mount_compliance",
    tests=("series",),
    parameters=(
        Parameter("stiffness", "N/m", 2e6, 5e4, 1e9, "stiffness of the joint beyond its play"),
        Parameter("play", "m", 2e-4, 0.0, 5e-3, "total play"),
    ),
    order=1,
    shows="a kink or plateau where the force changes sign, equally wide in displacement at any speed",
    separate="reverse the force slowly by hand: the joint moves without force",
    trial=trial,
)
