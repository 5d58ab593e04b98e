"""Oil with free gas: a spring in series that becomes stiffer as the pressure of the loaded chamber rises.

    d = F / k + g F / (P + F),      F_path(v - d') = F_0 + F,      the same with -F, -d and its g in compression

k in N/m the stiffness of the oil without gas, g in m the travel that the gas of the chamber takes (its volume over the
piston's area), P in N the pressure at rest over the same area, d in m the deflection, F_0 in N the path's force at
rest. The law of an isothermal gas in the chamber whose pressure rises. Solved for F in closed form, and implicitly with
the path (``model.chain``), second order in the step. Source: Boyle's law; effective bulk modulus of oil with entrained
gas, Merritt 1967.
"""

from math import sqrt

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.oil_spring import AT_REST
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import X

_LEAST_GAIN = 1.2  # ratio of the stiffness at the largest force to that at rest; below, it is oil without gas


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_0 + F(d), the root of F^2 / k + (P / k + g - |d|) F = P |d|."""
    stiffness, pressure = parameters[0], parameters[3]
    for i in range(force.size):
        d = kinematics[X, i]
        travel = parameters[1] if d > 0.0 else parameters[2]
        b = pressure / stiffness + travel - abs(d)
        root = sqrt(b * b + 4.0 * abs(d) * pressure / stiffness)
        carried = 2.0 * abs(d) * pressure / (b + root) if b > 0.0 else 0.5 * stiffness * (root - b)
        force[i] += settings[0] + (carried if d > 0.0 else -carried)


def trial(ranges: Ranges) -> Trial:
    """Gas takes at most a twentieth of the stroke; its pressure at rest is of the order of the force or more."""
    least = ranges.least_stiffness
    travel = 0.05 * ranges.stroke
    names = ("travel_rebound", "travel_compression")
    limits = {"stiffness": (4.0 * least, 1e9), "pressure": (0.1 * ranges.force, 10.0 * ranges.force)}
    values = {"stiffness": 40.0 * least, "pressure": ranges.force, "at_rest": ranges.oil_at_rest}
    starts = tuple(dict.fromkeys(names, share * travel) for share in (0.05, 0.01))

    def exclusion(values: Values) -> str:
        most = max(number(values, name) for name in names)
        pressure, stiffness = number(values, "pressure"), number(values, "stiffness")
        loaded = pressure + 2.0 * ranges.force
        soft = 1.0 / stiffness + most / pressure
        stiff = 1.0 / stiffness + most * pressure / loaded**2
        return "hardly becomes stiffer: oil without gas" if soft < _LEAST_GAIN * stiff else ""

    limits |= dict.fromkeys(names, (0.0, travel))
    return Trial(values | dict.fromkeys(names, 0.2 * travel), limits, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="oil_compressibility",
    tests=("series",),
    parameters=(
        Parameter("stiffness", "N/m", 5e6, 5e4, 1e9, "stiffness of the oil without gas"),
        Parameter("travel_rebound", "m", 2e-4, 0.0, 1e-2, "travel that the gas takes in rebound"),
        Parameter("travel_compression", "m", 2e-4, 0.0, 1e-2, "travel that the gas takes in compression"),
        Parameter("pressure", "N", 1000.0, 1.0, 1e5, "pressure at rest over the piston's area"),
    ),
    settings=(AT_REST,),
    order=2,
    of_oil=True,
    shows="the F-v loop opens most around zero force, and hardly at large forces",
    separate="the same motion with more gas pressure: the gas takes less travel",
    trial=trial,
)
