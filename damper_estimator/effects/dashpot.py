"""Dashpot in series with the path: oil that leaks or yields in series with the elements that produce the force.

    F = c d',      F = F_path(x - d, v - d')

c in N s/m, d in m. Solved implicitly, second order in the step (``model.chain``). On the first sample after a reset
it is a stiff spring, so that d starts near zero. Source: Spencer et al. 1997, eq. (12), the dashpot c1.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import DT, V, X

FIRST = 1e8  # N/m, on the first sample after a reset

_LEAK = "is a leak in front of a curve: another curve"


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Force of the dashpot over its deflection X and deflection rate V."""
    for i in range(force.size):
        if kinematics[DT, i] > 0.0:
            force[i] += parameters[0] * kinematics[V, i]
        else:
            force[i] += FIRST * kinematics[X, i]


def trial(ranges: Ranges) -> Trial:
    """Its deflection rate is at most a fifth of the speed. In front of a curve it is a leak, which makes another curve,
    unless it explains clearly more than any curve.
    """
    least = max(5.0 * ranges.force / ranges.speed, 500.0)
    limits, starts = {"damping": (least, 1e7)}, ({"damping": 15.0 * least},)
    return Trial({"damping": 4.0 * least}, limits, starts, lambda values: _LEAK, imitates="curve")


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="hysteresis",
    parameters=(Parameter("damping", "N s/m", 3e4, 100.0, 1e8, "rate of the dashpot"),),
    order=2,
    shows="the force rounds off at low velocity, after each reversal and before it",
    separate="the same amplitude at two low frequencies",
    trial=trial,
    general=True,
)
