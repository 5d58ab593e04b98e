"""Dahl friction: elastic before it slides.

    F = sigma_0 u,      du/dx = sgn(y) |y|^i,      y = 1 - sgn(v) sigma_0 u / F_c

sigma_0 in N/m, F_c in N, i without unit. It is rate-independent, so it is integrated over displacement: over a step
without reversal y has a closed form, y^(1-i) = y_0^(1-i) + (i - 1) sigma_0 |dx| / F_c (for i = 1 an exponential).
States: F / F_c and the last displacement; second order in the step, from the reversals. Source: Gao et al., eq. (2);
Dahl 1968.
"""

from collections.abc import Mapping
from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, sliding_soon, spread
from damper_estimator.signals.layout import DT, X

_LONGEST_TRAVEL = 2e-3  # m


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += sigma_0 u; parameters F_c, sigma_0, i."""
    limit, stiffness, exponent = parameters[0], parameters[1], parameters[2]
    for i in range(force.size):
        x = kinematics[X, i]
        if kinematics[DT, i] <= 0.0:
            state[0] = 0.0
        else:
            move = x - state[1]
            direction = 1.0 if move > 0.0 else -1.0
            y = max(1.0 - direction * state[0], 0.0)
            travel = stiffness * abs(move) / max(limit, 1e-9)
            if abs(exponent - 1.0) < 1e-9:
                y *= exp(-travel)
            elif y > 0.0:
                power = y ** (1.0 - exponent) + (exponent - 1.0) * travel
                y = power ** (1.0 / (1.0 - exponent)) if power > 0.0 else 0.0
            state[0] = direction * (1.0 - y)
        state[1] = x
        force[i] += limit * state[0]


def exclusion(values: Mapping[str, float]) -> str:
    """Friction slides after a short travel; a longer one would be another effect."""
    travel = values["force"] / values["stiffness"]
    return f"would slide after {1e3 * travel:.2g} mm only: no friction" if travel > _LONGEST_TRAVEL else ""


def plausible(values: Mapping[str, float]) -> float:
    """The sooner it slides, the better."""
    return sliding_soon(values["force"] / values["stiffness"])


def trial(ranges: Ranges) -> Trial:
    """Friction slides after a short travel; a longer one would be another effect."""
    least = max(ranges.force / 5e-3, 1e4)
    return Trial(
        values={"stiffness": 4.0 * least},
        limits={"stiffness": (least, 1e8), "force": (0.0, 2.0 * ranges.force), "exponent": (0.5, 2.0)},
        starts=spread(force=(0.05 * ranges.force, 0.2 * ranges.force), stiffness=(1.5 * least, 10.0 * least)),
        exclusion=exclusion,
        plausible=plausible,
    )


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="friction",
    tests=("friction step",),
    parameters=(
        Parameter("force", "N", 50.0, 0.0, 10000.0, "friction force while sliding"),
        Parameter("stiffness", "N/m", 1e5, 1e3, 1e8, "stiffness before sliding"),
        Parameter("exponent", "1", 1.0, 0.2, 3.0, "shape of the transition to sliding"),
    ),
    states=2,
    order=2,
    shows="an odd step of the force at each reversal, built up over a short travel and not over a time",
    separate="a slow triangle at two amplitudes: friction builds up over the same travel at any speed",
    trial=trial,
)
