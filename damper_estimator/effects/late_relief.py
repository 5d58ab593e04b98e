"""Relief that opens later than in the model: more force beyond the speed at which it used to open, per direction.

    F += R_r s(v) for v > 0,      F -= R_c s(-v) for v < 0,      s(u) = 1 - exp(-max(u - u_o, 0) / w)

R_r, R_c >= 0 in N is the force by which the preload of the blow-off valve is larger than in the model, u_o in m/s (one
for each direction) the speed at which the valve used to open, and w in m/s the range of speed in which it opens now.
The reverse of ``relief``, which softens a curve that has no valve. No state. Source: the blow-off characteristic of
Carrera Akutain et al., section 3, of two preloads.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import V

_EARLIEST = 0.1  # of the recorded speed
_LATE = 0.25  # of it: what begins before that is a change of the whole curve


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += R (1 - exp(-(|v| - u_o) / w)) sgn v beyond u_o."""
    for i in range(force.size):
        v = kinematics[V, i]
        k = 0 if v > 0.0 else 2
        beyond = abs(v) - parameters[k + 1]
        if beyond > 0.0:
            raised = parameters[k] * (1.0 - exp(-beyond / parameters[4]))
            force[i] += raised if v > 0.0 else -raised


def trial(ranges: Ranges) -> Trial:
    """The valve used to open within the recorded speeds, above the lowest ones."""
    speed = ranges.speed
    openings = dict.fromkeys(("opening_rebound", "opening_compression"), (_EARLIEST * speed, 0.8 * speed))
    limits = openings | {"width": (0.03 * speed, 0.5 * speed)}
    values = dict.fromkeys(openings, 0.3 * speed) | {"width": 0.2 * speed}
    starts = spread(opening_rebound=(0.15 * speed, 0.4 * speed), opening_compression=(0.15 * speed, 0.4 * speed))

    def exclusion(fitted: Values) -> str:
        raised = {way: number(fitted, f"raised_{way}") for way in ("rebound", "compression")}
        most = max(raised.values())
        early = all(
            number(fitted, f"opening_{way}") < _LATE * speed for way, newtons in raised.items() if newtons >= 0.1 * most
        )
        return "begins at low speed: a change of the whole curve" if early else ""

    return Trial(values, limits, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="blow_off",
    tests=("blow-off",),
    parameters=(
        Parameter("raised_rebound", "N", 100.0, 0.0, 2e4, "preload in rebound above the model's", linear=True),
        Parameter("opening_rebound", "m/s", 0.3, 1e-3, 5.0, "speed at which the valve used to open in rebound"),
        Parameter("raised_compression", "N", 100.0, 0.0, 2e4, "preload in compression above the model's", linear=True),
        Parameter("opening_compression", "m/s", 0.3, 1e-3, 5.0, "speed at which it used to open in compression"),
        Parameter("width", "m/s", 0.1, 1e-3, 5.0, "range of speed in which it opens now"),
    ),
    shows="above a certain speed more force than the model's, by a nearly constant amount",
    separate="speeds well above and below the knee in both directions",
    trial=trial,
)
