"""Passage with a check valve beside the path: in one direction oil flows past the elements that produce the force.

    F = F_0 + c_r d'  for d' > 0,      F = F_0 + c_c d'  for d' < 0,      F = F_path(v - d')

c_r, c_c in N s/m are the slopes of the passage in rebound and compression, d' in m/s the flow through it over the
piston's area, F_0 in N (setting) the path's force at rest. A large slope is a closed valve. Beside a viscous path it is
another slope in one direction, which ``direction_curve`` describes as well; beside the yield of a magneto-rheological
fluid the force rises from zero with the velocity in that direction, and holds in the other one. Solved implicitly,
second order in the step (``model.chain``). Source: balance of the flows through parallel passages; Dixon 2008.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values, number
from damper_estimator.effects.dashpot import FIRST
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import DT, V, X

_ONE_SIDED = 4.0  # least ratio of the slopes


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Force of the passage over the flow V through it."""
    for i in range(force.size):
        if kinematics[DT, i] > 0.0:
            rate = kinematics[V, i]
            force[i] += settings[0] + (parameters[0] if rate > 0.0 else parameters[1]) * rate
        else:
            force[i] += settings[0] + FIRST * kinematics[X, i]


def trial(ranges: Ranges) -> Trial:
    """A passage that is open alike in both directions is a leak (``dashpot``)."""
    slope = ranges.force / ranges.speed
    limits = {"damping_rebound": (slope, 1e4 * slope), "damping_compression": (slope, 1e4 * slope)}
    values = {"damping_rebound": 1e3 * slope, "damping_compression": 10.0 * slope, "at_rest": ranges.oil_at_rest}
    starts = tuple(
        {"damping_rebound": rebound * slope, "damping_compression": compression * slope}
        for rebound, compression in ((1e3, 40.0), (10.0, 1e3), (40.0, 1e3))
    )

    def exclusion(values: Values) -> str:
        slopes = sorted(number(values, f"damping_{way}") for way in ("rebound", "compression"))
        return "is open in both directions: a leak" if slopes[1] < _ONE_SIDED * slopes[0] else ""

    return Trial(values, limits, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="asymmetry",
    parameters=(
        Parameter("damping_rebound", "N s/m", 1e6, 1.0, 1e9, "slope of the passage in rebound"),
        Parameter("damping_compression", "N s/m", 3e4, 1.0, 1e9, "slope of the passage in compression"),
    ),
    settings=(Setting("at_rest", "N", 0.0, "force of the path at rest, where no oil flows", adds=True),),
    order=2,
    of_oil=True,
    shows="in one direction the force rises from zero with the velocity, in the other one it holds",
    separate="slow triangles: the force of one direction falls with the speed, that of the other one stays",
    trial=trial,
)
