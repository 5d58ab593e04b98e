"""Void in the rod-side chamber: in compression the gas drives oil through the piston with no more than its pressure.

    F = F_0 + k d  for k d > -F_v,      F = F_0 - F_v + k_g (d + F_v / k)  beyond,      F = F_path(v - d')
    F_v = F_x - r k_g x

k in N/m is the oil's stiffness, d in m the deflection, F_v in N the force at which the rod-side pressure has fallen to
that of vapour, k_g in N/m the stiffness of the gas, n p A^2 / V with the piston's area A: the oil that does not pass
the piston compresses it. So does the rod, with an area of r A, by the displacement x in m: the further the damper is
extended, the smaller is the force at which it cavitates, F_x in N at x = 0. F_0 in N is the path's force at rest, where
the pressures are equal. The void has to close before the force returns to that of the valves, and until then oil passes
the piston faster than the piston moves: the force falls late. Solved implicitly, second order in the step
(``model.chain``). Source: balance of the flows in a monotube damper; Boyle's law to first order; Dixon 2008.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.oil_spring import AT_REST
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import STROKE, X

_LEAST = 0.05  # of the pressure at x = 0: gas expands, but never away


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_0 + k d, with the slope k_g beyond -F_v."""
    for i in range(force.size):
        linear = parameters[0] * kinematics[X, i]
        rod = parameters[3] * parameters[2] * kinematics[STROKE, i]
        opening = max(parameters[1] - rod, _LEAST * parameters[1])
        beyond = min(linear + opening, 0.0)
        force[i] += settings[0] + linear - beyond * (1.0 - parameters[2] / parameters[0])


def trial(ranges: Ranges) -> Trial:
    """Only a force that is exceeded is visible. The gas is soft: over a void as long as the stroke its force changes by
    a few times that of the damper. With a stiffer gas the effect would be oil that is softer in compression.
    """
    least = ranges.least_stiffness
    soft = ranges.force / ranges.stroke
    opening = (0.5 * ranges.force, 6.0 * ranges.force)
    limits = {"stiffness": (least, 1e9), "opening": opening, "gas": (1e-3 * soft, 6.0 * soft), "rod": (0.0, 0.4)}
    starts = spread(opening=tuple(level * ranges.force for level in (0.6, 1.2, 1.5, 2.2, 3.0)))
    values = {"stiffness": 80.0 * least, "opening": ranges.force, "gas": 4.0 * soft, "rod": 0.12}
    values["at_rest"] = ranges.oil_at_rest

    def exclusion(values: Values) -> str:
        is_beyond = number(values, "opening") > 3.0 * ranges.force
        return "opens beyond the recorded forces: oil, or a mount" if is_beyond else ""

    return Trial(values, limits, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="cavitation",
    tests=("series", "history"),
    parameters=(
        Parameter("stiffness", "N/m", 2e6, 5e4, 1e9, "stiffness of the oil without a void"),
        Parameter(
            "opening",
            "N",
            1000.0,
            1.0,
            1e6,
            "compression force, beyond that at rest, at which a void opens at displacement 0",
        ),
        Parameter("gas", "N/m", 1e4, 1.0, 1e9, "stiffness of the gas on the whole area of the piston"),
        Parameter("rod", "1", 0.0, 0.0, 0.9, "area of the rod over that of the piston"),
    ),
    settings=(AT_REST,),
    order=2,
    of_oil=True,
    shows="compression loses force above a level, and has more than before when the piston slows down",
    separate="the same motion with more gas pressure",
    trial=trial,
)
