"""Pocket of gas or vapour in a chamber: a spring in series that becomes soft as the pressure falls.

    F = F_0 + k d / (1 + k d / L_r)  for d > 0,      F_0 + k d / (1 - k d / L_c)  for d <= 0,      F = F_path(v - d')

k in N/m, d in m the deflection, L_r and L_c in N the forces that rebound and compression approach as the pocket
expands: the law of an isothermal gas in the chamber whose pressure falls. F_0 in N is the path's force at rest, where
no oil flows and the pressures are equal: a curve may contain a constant. The pocket has to close again before the
force returns, so that after a fast stroke a part of the travel is lost. Solved implicitly, second order in the step
(``model.chain``). Source: Boyle's law; cavitation and aeration of dampers, Duym 2000.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.oil_spring import AT_REST
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import X

_ALIKE = 1.5  # ratio of the limits; the areas of the two chambers alone differ by more


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_0 + k d / (1 + |k d| / L), with the limit of the direction."""
    for i in range(force.size):
        linear = parameters[0] * kinematics[X, i]
        limit = parameters[1] if linear > 0.0 else parameters[2]
        force[i] += settings[0] + linear / (1.0 + abs(linear) / limit)


def trial(ranges: Ranges) -> Trial:
    """A pocket in one chamber limits the force of one direction within what was recorded; otherwise it is oil."""
    least = ranges.least_stiffness
    far, near = 30.0 * ranges.force, 1.5 * ranges.force
    names = ("limit_rebound", "limit_compression")
    limits = {"stiffness": (least, 1000000000.0)} | dict.fromkeys(names, (0.3 * ranges.force, far))
    starts = tuple(
        {"stiffness": factor * least, name: near} | {other: far for other in names if other != name}
        for factor in (4.0, 20.0)
        for name in names
    )

    def exclusion(values: Values) -> str:
        nearest, farther = sorted(number(values, name) for name in names)
        if nearest > 3.0 * ranges.force:
            return "hardly becomes softer: oil, or a mount"
        return "becomes soft alike in both directions: no pocket in a chamber" if farther < _ALIKE * nearest else ""

    return Trial(starts[0] | {"at_rest": ranges.oil_at_rest}, limits, starts[1:], exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="cavitation",
    tests=("series", "history"),
    parameters=(
        Parameter("stiffness", "N/m", 2e6, 5e4, 1e9, "stiffness of the oil with the pocket at rest"),
        Parameter("limit_rebound", "N", 5000.0, 1.0, 1e6, "force that rebound approaches"),
        Parameter("limit_compression", "N", 5000.0, 1.0, 1e6, "force that compression approaches"),
    ),
    settings=(AT_REST,),
    order=2,
    of_oil=True,
    shows="one direction loses force in fast strokes, and a part of the travel after them has no force",
    separate="the same motion with more gas pressure",
    trial=trial,
)
