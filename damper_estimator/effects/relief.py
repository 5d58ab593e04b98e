"""Relief: beyond an opening speed the damper is softer than its curve, per direction.

    F -= c_r v_r ((v - v_r) / v_r)^p  for v > v_r,      F += c_c v_c ((-v - v_c) / v_c)^p  for v < -v_c

c >= 0 in N s/m is the loss of slope when the blow-off valve opens; v_r, v_c in m/s are the opening speeds; p without
unit is 1 for a straight loss, less where the valve opens at once and the force drops, more where it opens slowly. The
knee is rounded over a tenth of the opening speed. The effect corrects a curve without the knee; ``leak_blow_off_port``
is a damper's whole hydraulic force. No state. Source: the blow-off characteristic of Carrera Akutain et al., section 3.
"""

from math import sqrt

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import V

_ROUND = 0.1  # of the opening value
_EARLIEST = 0.06  # of the recorded speed


@compiled
def beyond(value, opening):
    """How far a value (>= 0) is beyond its opening one: half of (u + |u|) with the corner rounded, and zero at zero."""
    past = value - opening
    width = _ROUND * opening
    return 0.5 * (past + sqrt(past * past + width * width)) - 0.5 * (sqrt(opening**2 + width**2) - opening)


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F -= c v_o (max(|v| - v_o, 0) / v_o)^p sgn v, rounded."""
    for i in range(force.size):
        v = kinematics[V, i]
        k = 0 if v > 0.0 else 2
        opening = parameters[k + 1]
        loss = parameters[k] * opening * max(beyond(abs(v), opening) / opening, 0.0) ** parameters[4]
        force[i] -= loss if v > 0.0 else -loss


def trial(ranges: Ranges) -> Trial:
    """The valve opens within the recorded speeds, above the lowest ones."""
    speed = ranges.speed
    limits = dict.fromkeys(("opening_rebound", "opening_compression"), (_EARLIEST * speed, 0.8 * speed))
    values = dict.fromkeys(limits, 0.3 * speed)
    openings = (0.15 * speed, 0.5 * speed)
    starts = spread(opening_rebound=openings, opening_compression=openings, exponent=(0.5, 1.0))

    def exclusion(fitted: Values) -> str:
        early = all(number(fitted, name) < 1.05 * _EARLIEST * speed for name in limits)
        return "opens at once in both directions: a step, as of friction" if early else ""

    return Trial(values, limits | {"exponent": (0.3, 2.0)}, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="blow_off",
    tests=("blow-off",),
    parameters=(
        Parameter("softening_rebound", "N s/m", 500.0, 0.0, 1e5, "loss of slope in rebound", linear=True),
        Parameter("opening_rebound", "m/s", 0.3, 1e-3, 5.0, "speed at which the valve opens in rebound"),
        Parameter("softening_compression", "N s/m", 500.0, 0.0, 1e5, "loss of slope in compression", linear=True),
        Parameter("opening_compression", "m/s", 0.3, 1e-3, 5.0, "speed at which the valve opens in compression"),
        Parameter("exponent", "1", 1.0, 0.2, 3.0, "shape of the loss beyond the opening speed"),
    ),
    shows="a knee in F-v: above a certain speed the force grows much more slowly than the model's",
    separate="speeds well above and below the knee in both directions",
    trial=trial,
)
