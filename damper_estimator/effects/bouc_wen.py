"""Bouc-Wen hysteresis: from elastic to sliding, smoothly.

    F = alpha z,      dz/dx = delta - (beta + gamma sgn(z v)) |z|^n

alpha in N, delta, beta, gamma in 1/m, z and n without unit. z saturates at (delta / (beta + gamma))^(1/n);
its scale is redundant with alpha: models fix one of them. It is rate-independent and is integrated over displacement by
the fourth-order Runge-Kutta rule, in as many substeps as its stiffness needs. States: z and the last displacement;
second order in the step, from the reversals. Source: Gao et al., eq. (3); Bouc 1967, Wen 1976.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial, slides_early
from damper_estimator.signals.layout import DT, X

_PART = 0.3  # of the length over which z settles
_SLID = 1e-11  # of saturation


@compiled
def slope(z, direction, delta, beta, gamma, n):
    """dz/dx for motion in one direction."""
    sign = 1.0 if z * direction > 0.0 else -1.0
    return delta - (beta + gamma * sign) * abs(z) ** n


@compiled
def moved(z, move, delta, beta, gamma, n):
    """z after a displacement ``move`` in one direction."""
    direction = 1.0 if move > 0.0 else -1.0
    saturated = (delta / max(beta + gamma, 1e-12)) ** (1.0 / n)
    limit = max(abs(z), saturated)
    settling = n * (beta + abs(gamma)) * limit ** (n - 1.0) + delta / max(saturated, 1e-9)
    parts = min(int(abs(move) * settling / _PART) + 1, 400)
    h = move / parts
    for _ in range(parts):
        k1 = slope(z, direction, delta, beta, gamma, n)
        # Fully sliding: the remaining displacement changes nothing.
        if abs(k1 * move) <= _SLID * limit:
            break
        k2 = slope(z + 0.5 * h * k1, direction, delta, beta, gamma, n)
        k3 = slope(z + 0.5 * h * k2, direction, delta, beta, gamma, n)
        k4 = slope(z + h * k3, direction, delta, beta, gamma, n)
        z += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
        z = min(max(z, -limit), limit)
    return z


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += alpha z."""
    for i in range(force.size):
        x = kinematics[X, i]
        if kinematics[DT, i] <= 0.0:
            state[0] = 0.0
        else:
            state[0] = moved(state[0], x - state[1], parameters[1], parameters[2], parameters[3], parameters[4])
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
    saturated = (delta / (number(values, "beta") + number(values, "gamma"))) ** (1.0 / number(values, "n"))
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
