"""Gas force that the damper has lost, beside the model's.

    F = F_lost [(V / (V + A_rod x))^n - r],      n = 1.4

F_lost in N, V in m^3 the gas volume at x = 0, A_rod in m^2, x in m: the force of ``gas_spring`` with the other sign,
for a model that was identified before gas escaped. r is 0; r = 1 leaves only the change from displacement 0, where the
mean is not compared. No state. Source: Carrera Akutain et al., eqs. (6) to (10), as a difference of two charges.
"""

from dataclasses import replace

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, number
from damper_estimator.effects.gas_spring import SETTINGS, TESTS, VOLUME, gas_force
from damper_estimator.effects.gas_spring import trial as gas_trial
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_lost [(V / (V + A x))^n - r]."""
    for i in range(force.size):
        force[i] += gas_force(parameters, settings, kinematics[X, i])


def trial(ranges: Ranges) -> Trial:
    """As ``gas_spring``, and from a long column; also for a model without gas, which has left its force out or to the
    gauge's zero.
    """
    tried = gas_trial(ranges)
    return replace(tried, starts=(*tried.starts, {"volume": 10.0 * number(tried.values, "volume")}))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="gas_spring",
    tests=TESTS,
    parameters=(
        Parameter("lost_force", "N", 50.0, 0.0, 5000.0, "lost gas force at displacement 0", linear=True),
        VOLUME,
    ),
    settings=SETTINGS,
    beside_oil=True,
    shows="less force pushes the rod out, above all in compression, at any velocity",
    separate="a slow stroke over the whole travel, and the gauge's reading with the damper unhooked",
    trial=trial,
)
