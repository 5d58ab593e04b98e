"""Bouc-Wen hysteresis: from elastic to sliding, smoothly.

    F = alpha z,      dz/dx = delta - (beta + gamma sgn(z v)) |z|^n

alpha in N, delta, beta, gamma in 1/m, z and n without unit. z saturates at (delta / (beta + gamma))^(1/n);
its scale is redundant with alpha: models fix one of them. It is rate-independent and is integrated over displacement
in parts: in each |z|^n is replaced by its parabola about the start of the part, and the equation that is left, a
Riccati equation, is solved exactly. Towards saturation parts may therefore be of any length. States: z and the last
displacement; second order in the step, from the reversals. Source: Gao et al., eq. (3); Bouc 1967, Wen 1976.
"""

from math import sqrt, tan, tanh

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial, slides_early
from damper_estimator.signals.layout import DT, X

_TURN = 0.25  # of z: by how much it changes in a part at most, divided by n - 1 where that is larger
_NEAR = 0.03  # of saturation: near zero, where |z|^n has no parabola but is small, parts are this long
_STRAIGHT = 1e-12  # a smaller discriminant is none
_STEEP = 1.5  # largest argument of a tangent
_MOST = 1000  # parts


@compiled
def saturation(delta, beta, gamma, n):
    """The largest z that motion in one direction leads to."""
    return (delta / max(beta + gamma, 1e-12)) ** (1.0 / n)


@compiled
def moved(z, move, saturated, delta, beta, gamma, n):
    """z after a displacement ``move`` in one direction; ``saturated`` from ``saturation``.

    With y = z / saturated along the motion and u = delta |dx| / saturated, dy/du = f(y) = 1 - s |y|^n, where s = 1
    while z is driven up and (beta - gamma) / (beta + gamma) while it is driven back.
    """
    direction = 1.0 if move > 0.0 else -1.0
    back = (beta - gamma) / max(beta + gamma, 1e-12)
    turn = _TURN / max(n - 1.0, 1.0)
    y, left = direction * z / saturated, abs(move) * delta / saturated
    for _ in range(_MOST):
        if left <= 0.0:
            break
        size = abs(y)
        power = (1.0 if y > 0.0 else back) * size**n
        rate = 1.0 - power
        if size < _NEAR:
            length = min(left, _NEAR)
            middle = y + 0.5 * length * rate
            y += length * (1.0 - (1.0 if middle > 0.0 else back) * abs(middle) ** n)
        else:
            first, second = -n * power / y, -n * (n - 1.0) * power / (y * y)
            # Driven back, z leaves saturation ever faster.
            fastest = abs(rate) + max(first, 0.0) * turn * size
            length = left if fastest * left <= turn * size else turn * size / fastest
            half = _half_tangent(first * first - 2.0 * rate * second, length)
            y += 2.0 * rate * half / (1.0 - first * half)
        left -= length
    return direction * saturated * min(y, 1.0)


@compiled
def _half_tangent(discriminant, length):
    """tanh(r length / 2) / r with r the root of the discriminant, for a negative one the tangent."""
    if discriminant > _STRAIGHT:
        root = sqrt(discriminant)
        return tanh(0.5 * root * length) / root
    if discriminant < -_STRAIGHT:
        root = sqrt(-discriminant)
        return tan(min(0.5 * root * length, _STEEP)) / root
    return 0.5 * length


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += alpha z."""
    delta, beta, gamma, n = parameters[1], parameters[2], parameters[3], parameters[4]
    saturated = saturation(delta, beta, gamma, n)
    for i in range(force.size):
        x = kinematics[X, i]
        if kinematics[DT, i] <= 0.0:
            state[0] = 0.0
        else:
            state[0] = moved(state[0], x - state[1], saturated, delta, beta, gamma, n)
        state[1] = x
        force[i] += parameters[0] * state[0]


PARAMETERS = (
    Parameter("alpha", "N", 120.0, 0.0, 20000.0, "hysteresis force per z", linear=True),
    Parameter("delta", "1/m", 300.0, 1.0, 1e5, "slope of z before sliding"),
    Parameter("beta", "1/m", 200.0, 1e-3, 1e6, "saturation, independent of the direction"),
    Parameter("gamma", "1/m", 100.0, 1e-3, 1e6, "saturation, dependent on the direction"),
    Parameter("n", "1", 1.5, 1.0, 10.0, "sharpness of the transition"),
)


def exclusion(values: Values) -> str:
    """Sliding soon it would be dry friction; at its first slope z reaches saturation after z_s / delta."""
    delta = number(values, "delta")
    saturated = saturation(delta, number(values, "beta"), number(values, "gamma"), number(values, "n"))
    return slides_early(saturated / delta)


def trial(ranges: Ranges) -> Trial:
    """z settles over a distance between a thousandth and a fifth of the stroke; alpha sets its scale."""
    way = 0.02 * ranges.stroke
    limits = dict.fromkeys(("delta", "beta", "gamma"), (2.0 / ranges.stroke, 500.0 / ranges.stroke))
    values = {"delta": 1.0 / way, "beta": 0.6 / way, "gamma": 0.4 / way, "n": 1.2}
    starts = tuple({k: v * f for k, v in values.items() if k != "n"} for f in (0.3, 3.0))
    return Trial(values, {**limits, "n": (1.0, 2.0)}, starts, exclusion, imitates="friction step")


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    tests=("memory",),
    parameters=PARAMETERS,
    states=2,
    order=2,
    shows="F-x loops with rounded corners after each reversal, the same at any frequency",
    separate="the same amplitude at two frequencies: this hysteresis does not change",
    trial=trial,
    general=True,
)
