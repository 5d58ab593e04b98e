"""Yield of many small parts, each elastic until it slips: memory of every reversal, also inside a loop.

    F = F_y mean_k s_k,      ds_k = dx / w_k  while |s_k| < 1,      w_k = w exp(g n_k),      n_k = -1 ... 1

F_y in N the force while all parts slip, w in m the median travel before a part slips, g without unit the spread of the
travels, whose logarithms are evenly spaced (small: all slip at once, elastic and then sliding); nine parts of equal
strength. Rate-independent. After each reversal the branch is the first loading at twice its size (Masing's rule), and
an interrupted branch continues where it was. States: s_k and the last displacement; second order in the step, from the
reversals. Source: W. D. Iwan, A distributed-element model for hysteresis and its steady-state dynamic response, J.
Appl. Mech. 33 (1966), with this distribution.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import DT, X

PARTS = 9
"""Parts, of equal strength."""


@compiled
def slipped(state, x, way, spread):
    """Mean share (-1 to 1) of the parts moved to ``x``; ``state`` holds their shares and the last displacement."""
    move = x - state[PARTS]
    state[PARTS] = x
    total, travel, ratio = 0.0, way * exp(-spread), exp(2.0 * spread / (PARTS - 1.0))
    for k in range(PARTS):
        state[k] = min(1.0, max(-1.0, state[k] + move / travel))
        total += state[k]
        travel *= ratio
    return total / PARTS


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_y mean s_k."""
    for i in range(force.size):
        if kinematics[DT, i] <= 0.0:
            for k in range(PARTS):
                state[k] = 0.0
            state[PARTS] = kinematics[X, i]
        force[i] += parameters[0] * slipped(state, kinematics[X, i], parameters[1], parameters[2])


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="friction",
    tests=("friction step",),
    parameters=(
        Parameter("force", "N", 200.0, 0.0, 50000.0, "yield force", linear=True),
        Parameter("way", "m", 3e-4, 1e-6, 0.05, "median travel before a part slips"),
        Parameter("spread", "1", 1.0, 0.1, 4.0, "spread of the travels; 0.1: nearly all parts slip at once"),
    ),
    states=PARTS + 1,
    order=2,
    shows="an odd step of the force at each reversal; small loops inside large ones are parts of the same curve",
    separate="a slow triangle with small reversals inside a large one",
    trial=None,
)
