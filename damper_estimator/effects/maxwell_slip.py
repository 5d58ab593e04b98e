"""Hysteresis of any shape over displacement: elements that are elastic and then slide, side by side.

    F = sum over k of F_k z_k / w_k,      z_k <- z_k + dx, held between -w_k and w_k

F_k in N is the force of an element that slides, w_k in m (settings) the travel until it does. The loop's corner is a
polygon through these travels, so any hysteresis that does not depend on the rate is approximated. States: z_k and the
last displacement; exact over a step without reversal, first order otherwise. Source: generalised Maxwell slip,
Iwan 1966; the Prandtl-Ishlinskii operator.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import DT, X

_MOST = 6  # elements; more are ignored


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += sum F_k z_k / w_k."""
    count = min(parameters.size, _MOST)
    for i in range(force.size):
        x = kinematics[X, i]
        moved = x - state[_MOST] if kinematics[DT, i] > 0.0 else 0.0
        state[_MOST] = x
        for k in range(count):
            travel = settings[k]
            if kinematics[DT, i] <= 0.0:
                state[k] = 0.0
            state[k] = min(max(state[k] + moved, -travel), travel)
            force[i] += parameters[k] * state[k] / travel


def trial(ranges: Ranges) -> Trial:
    """Travels beyond those of seals, which are friction; what slides within a part of the stroke only."""
    longest = 0.25 * ranges.stroke
    travels = tuple(travel for travel in (8e-4, 2e-3, 5e-3) if travel < longest)
    travels = travels if len(travels) > 1 else (0.4 * longest, longest)
    return Trial({"travel": travels, "force": (0.0,) * len(travels)})


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    tests=("memory",),
    parameters=(
        Parameter("force", "N", 0.0, 0.0, 20000.0, "force of an element that slides", linear=True, size="travel"),
    ),
    settings=(
        Setting("travel", "m", (2e-4, 8e-4, 3e-3), "until an element slides, up to six", lower=1e-6, increasing=True),
    ),
    states=_MOST + 1,
    order=1,
    shows="F-x loops with rounded corners after each reversal, the same at any frequency",
    separate="the same amplitude at two frequencies: this hysteresis does not change",
    trial=trial,
    general=True,
)
