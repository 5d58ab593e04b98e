"""Compressibility of the oil: the path's force acts through a spring, one stiffness per direction.

    F = F_0 + k_r d  for d > 0,      F_0 + k_c d  for d <= 0,      F = F_path(v - d')

k in N/m, d in m the deflection, F_0 in N the path's force at rest, where no oil flows and the pressures are equal. A
monotube's two chambers differ in volume and so in stiffness. Solved implicitly, second order in the step
(``model.chain``), stable for any stiffness. Source: Maxwell element; Lang 1977.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import X

AT_REST = Setting("at_rest", "N", 0.0, "force of the path at rest, where the pressures are equal", adds=True)


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Force of the spring over its deflection, row X."""
    for i in range(force.size):
        d = kinematics[X, i]
        force[i] += settings[0] + (parameters[0] if d > 0.0 else parameters[1]) * d


def trial(ranges: Ranges) -> Trial:
    """Oil deflects by at most a twentieth of the stroke."""
    least = ranges.least_stiffness
    names = ("stiffness_rebound", "stiffness_compression")
    starts = [dict.fromkeys(names, factor * least) for factor in (10.0, 40.0)]
    values = dict.fromkeys(names, 4.0 * least) | {"at_rest": ranges.oil_at_rest}
    return Trial(values, dict.fromkeys(names, (least, 1000000000.0)), tuple(starts))


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="oil_compressibility",
    tests=("series",),
    parameters=(
        Parameter("stiffness_rebound", "N/m", 2e6, 5e4, 1e9, "stiffness of the oil in rebound"),
        Parameter("stiffness_compression", "N/m", 2e6, 5e4, 1e9, "stiffness of the oil in compression"),
    ),
    settings=(AT_REST,),
    order=2,
    of_oil=True,
    shows="the F-v loop opens with frequency, most at low speed where the damper is stiffest",
    separate="impedance of the mount alone; two temperatures (rubber softens, oil hardly)",
    trial=trial,
)
