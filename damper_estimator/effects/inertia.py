"""Inertia of the parts that move between displacement sensor and strain gauge.

    F = m a

m in kg, a in m/s^2. No state. Source: Newton; the virtual mass of Lozoya-Santos et al., eq. (9).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import A


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += m a."""
    for i in range(force.size):
        force[i] += parameters[0] * kinematics[A, i]


def trial(ranges: Ranges) -> Trial:
    """A damper's moving parts weigh some kilograms, a fixture may weigh more."""
    return Trial(limits={"mass": (0.0, ranges.most_mass)})


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="inertia",
    tests=("mass",),
    beside_oil=True,
    parameters=(Parameter("mass", "kg", 0.5, 0.0, 500.0, "moving mass", linear=True),),
    shows="more force while accelerating; at the reversals, where v = 0, the force follows the acceleration",
    separate="shake the unloaded gauge: only inertia remains",
    trial=trial,
)
