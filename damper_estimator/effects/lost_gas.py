"""Gas force that the damper has lost, beside the model's.

    F = F_lost [(V / (V + A_rod x))^n - r],      n = 1.4

F_lost in N, V in m^3 the gas volume at x = 0, A_rod in m^2, x in m: the force of ``gas_spring`` with the other sign,
for a model that was identified before gas escaped. r is 0; r = 1 leaves only the change from displacement 0, where the
mean is not compared. No state. Source: Carrera Akutain et al., eqs. (6) to (10), as a difference of two charges.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_lost [(V / (V + A x))^n - r]."""
    for i in range(force.size):
        # At least a twentieth of the volume, as in ``gas_spring``.
        expansion = max(1.0 + settings[0] * kinematics[X, i] / parameters[1], 0.05)
        force[i] += parameters[0] * (expansion ** -settings[1] - settings[2])


def trial(ranges: Ranges) -> Trial:
    """As ``gas_spring``; also for a model without gas, which has left its force out or to the gauge's zero."""
    area = 1.5e-4
    reach = max(-ranges.compression, 0.5 * ranges.stroke, 1e-3)
    limits = {"volume": (1.3 * area * reach, 60.0 * area * reach)}
    values = {"rod_area": area, "volume": 5.0 * area * reach, "relative": float(not ranges.with_mean)}
    return Trial(values, limits, spread(volume=(2.0 * area * reach, 50.0 * area * reach)))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="gas_spring",
    tests=(
        "travel",
        "spring",
    ),
    parameters=(
        Parameter("lost_force", "N", 50.0, 0.0, 5000.0, "lost gas force at displacement 0", linear=True),
        Parameter("volume", "m^3", 1.5e-4, 1e-6, 5e-3, "gas volume at displacement 0"),
    ),
    settings=(
        Setting("rod_area", "m^2", 1.5e-4, "cross-section of the rod", lower=1e-6),
        Setting("exponent", "1", 1.4, "1.0 isothermal (slow) to 1.4 isentropic", lower=1.0, upper=1.7),
        Setting("relative", "1", 0.0, "1: change from displacement 0, 0: with the static force", lower=0.0, upper=1.0),
    ),
    beside_oil=True,
    shows="less force pushes the rod out, above all in compression, at any velocity",
    separate="a slow stroke over the whole travel, and the gauge's reading with the damper unhooked",
    trial=trial,
)
