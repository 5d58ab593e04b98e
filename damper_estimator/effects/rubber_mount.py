"""Lossy rubber mount in series with the damper.

    F = k d + c d',      F = F_path(v - d')

k in N/m, c in N s/m, d in m. Solved implicitly, second order in the step (``model.chain``). Source: Kelvin-Voigt
element.
"""

from math import pi

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import V, X

_MOST_LOSS = 1.0  # at 10 Hz, of the stiffness: three times that of rubber, as of a hydraulic bush


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Force of the mount over its deflection X and deflection rate V."""
    for i in range(force.size):
        force[i] += parameters[0] * kinematics[X, i] + parameters[1] * kinematics[V, i]


def trial(ranges: Ranges) -> Trial:
    """A mount deflects by at most a twentieth of the stroke; rubber loses up to a third near 10 Hz."""
    least = ranges.least_stiffness
    starts = tuple({"stiffness": factor * least, "loss": 2e-3 * factor * least} for factor in (10.0, 40.0))
    limits = {"stiffness": (least, 1e9), "loss": (0.0, 2e4)}

    def exclusion(values: Values) -> str:
        lost = 2.0 * pi * 10.0 * number(values, "loss") / number(values, "stiffness")
        return "loses more than it stores: a dashpot in series" if lost > _MOST_LOSS else ""

    return Trial({"stiffness": 4.0 * least, "loss": 8e-3 * least}, limits, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="mount_compliance",
    tests=("series",),
    parameters=(
        Parameter("stiffness", "N/m", 1e6, 5e4, 1e9, "stiffness of the mount"),
        Parameter("loss", "N s/m", 500.0, 0.0, 1e5, "damping of the mount"),
    ),
    order=2,
    shows="the F-v loop opens with frequency, equally in rebound and compression",
    separate="repeat the test with a solid joint, or measure the mount alone",
    trial=trial,
)
