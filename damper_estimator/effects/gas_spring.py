"""Force of the gas behind the floating piston on the rod's area, isentropic.

    F = -F_static [(V / (V + A_rod x))^n - r],      n = 1.4

F_static in N, V in m^3 the gas volume at x = 0, A_rod in m^2, x in m (positive in extension, which expands
the gas: in compression the gas pushes the rod out, hence the sign). r is 0; r = 1 leaves only the change from
displacement 0, for a model with the static force in another effect. No state. Source: Carrera Akutain et al., eqs. (6)
to (10), in our signs.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import X

VOLUME = Parameter("volume", "m^3", 1.5e-4, 1e-6, 5e-3, "gas volume at displacement 0")
SETTINGS = (
    Setting("rod_area", "m^2", 1.5e-4, "cross-section of the rod", lower=1e-6),
    Setting("exponent", "1", 1.4, "1.0 isothermal (slow) to 1.4 isentropic", lower=1.0, upper=1.7),
    Setting("relative", "1", 0.0, "1: change from displacement 0, 0: with the static force", lower=0.0, upper=1.0),
)
TESTS = ("travel", "spring")


@compiled
def gas_force(parameters, settings, x):
    """F_static [(V / (V + A x))^n - r], N."""
    # At least a twentieth of the volume: an extreme displacement must not make the force infinite.
    expansion = max(1.0 + settings[0] * x / parameters[1], 0.05)
    return parameters[0] * (expansion ** -settings[1] - settings[2])


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F -= F_static [(V / (V + A x))^n - r]."""
    for i in range(force.size):
        force[i] -= gas_force(parameters, settings, kinematics[X, i])


def trial(ranges: Ranges) -> Trial:
    """The gas column is longer than the recorded compression, and finite; without a mean, only its change is new."""
    area = 1.5e-4
    reach = max(-ranges.compression, 0.5 * ranges.stroke, 1e-3)
    limits = {"volume": (1.3 * area * reach, 60.0 * area * reach)}
    values = {"rod_area": area, "volume": 5.0 * area * reach, "relative": float(not ranges.with_mean)}
    return Trial(values, limits, spread(volume=(2.0 * area * reach,)))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="gas_spring",
    tests=TESTS,
    parameters=(
        Parameter("static_force", "N", 200.0, 0.0, 5000.0, "gas force at displacement 0", linear=True),
        VOLUME,
    ),
    settings=SETTINGS,
    beside_oil=True,
    shows="the force falls as the damper extends, at any velocity, and more steeply in compression",
    separate="a slow stroke over the whole travel: gas is curved over displacement, a spring is straight",
    trial=trial,
)
