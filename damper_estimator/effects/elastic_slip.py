"""Yield of many small parts, each elastic until it slips: memory of every reversal, also inside a loop.

    F = F_y s,      s = mean_k s_k,      du/dt = v - v_c s,
    ds_k = du / w_k  while |s_k| < 1,      w_k = w exp(g n_k),      n_k = -1 ... 1

F_y in N the force while all parts slip, w in m the median travel before a part slips, g without unit the spread of the
travels, whose logarithms are evenly spaced (small: all slip at once, elastic and then sliding); nine parts of equal
strength. v_c in m/s is the creep: at a constant speed below it s = v / v_c, the force is viscous before the parts slip.
Without creep it does not depend on the rate: after each reversal the branch is the first loading at twice its size
(Masing's rule), and an interrupted branch continues where it was. States: s_k and the last displacement less the creep;
creep is implicit and of first order in the step, all else of second, from the reversals. Source: W. D. Iwan, A
distributed-element model for hysteresis and its steady-state dynamic response, J. Appl. Mech. 33 (1966), with this
distribution; the creep is the dashpot c_1 in series with the hysteresis of Spencer et al. 1997, eq. (12).
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT, X

PARTS = 9
"""Parts, of equal strength."""
_STEPS = 40  # of the search for the travel: halving alone would need no more
_EXACT = 1e-9  # of the median travel
_LEAST_CREEP, _MOST_CREEP = 0.002, 0.1  # of the speed


@compiled
def first_and_ratio(way, spread):
    """Share by which a move of 1 m loads the first part to slip, 1/m, and that of each part over the one before."""
    return exp(spread) / way, exp(-2.0 * spread / (PARTS - 1.0))


@compiled
def slipped(state, x, first, ratio):
    """Mean share (-1 to 1) of the parts moved to ``x``; ``state`` holds their shares and the last displacement."""
    load = (x - state[PARTS]) * first
    state[PARTS] = x
    total = 0.0
    for k in range(PARTS):
        state[k] = min(1.0, max(-1.0, state[k] + load))
        total += state[k]
        load *= ratio
    return total / PARTS


@compiled
def share_at(state, move, first, ratio):
    """Mean share of the parts after a ``move`` (m), and its slope over the move (1/m); the state stays as it is."""
    total, slope, rate = 0.0, 0.0, first
    for k in range(PARTS):
        share = state[k] + move * rate
        if abs(share) < 1.0:
            slope += rate
        total += min(1.0, max(-1.0, share))
        rate *= ratio
    return total / PARTS, slope / PARTS


@compiled
def crept(state, x, way, first, ratio, creep):
    """Mean share of the parts moved to ``x`` while they give way by ``creep`` (m) times it; the state of ``slipped``.

    They move by u = dx - creep s(u). s does not fall and lies between -1 and 1, so u lies within creep of dx.
    """
    if creep <= 0.0:
        return slipped(state, x, first, ratio)
    move = x - state[PARTS]
    low, high, u = move - creep, move + creep, move
    for _ in range(_STEPS):
        share, slope = share_at(state, u, first, ratio)
        error = u + creep * share - move
        if abs(error) <= _EXACT * way:
            break
        if error > 0.0:
            high = u
        else:
            low = u
        u -= error / (1.0 + creep * slope)
        if u < low or u > high:
            u = 0.5 * (low + high)
    state[PARTS] = x - u
    return slipped(state, x, first, ratio)


@compiled
def held(state, x, dt, way, first, ratio, creep):
    """Mean share of the parts at ``x``, ``dt`` after the last sample, with ``creep`` in m/s; they start unloaded.

    ``first`` and ``ratio`` are those of the way and its spread.
    """
    if dt <= 0.0:
        for k in range(PARTS):
            state[k] = 0.0
        state[PARTS] = x
    return crept(state, x, way, first, ratio, creep * max(dt, 0.0))


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_y mean s_k."""
    first, ratio = first_and_ratio(parameters[1], parameters[2])
    for i in range(force.size):
        x, dt = kinematics[X, i], kinematics[DT, i]
        force[i] += parameters[0] * held(state, x, dt, parameters[1], first, ratio, parameters[3])


def trial(ranges: Ranges) -> Trial:
    """Parts slip within a small part of the stroke, and creep at a small part of the speed. Without creep they are dry
    friction; with much of it, and stiff parts, the force would be viscous up to a speed: a change of the curve.
    """
    way = 0.01 * ranges.stroke
    limits = {"way": (0.02 * way, 5.0 * way), "spread": (0.1, 2.5), "creep": (0.0, _MOST_CREEP * ranges.speed)}
    values = {"way": 0.3 * way, "spread": 1.0, "creep": 0.02 * ranges.speed}

    def exclusion(values: Values) -> str:
        creep = number(values, "creep") / ranges.speed
        if creep < _LEAST_CREEP:
            return "does not give way at low speed: dry friction"
        return "yields at a tenth of the speed only: a change of the curve" if creep > 0.95 * _MOST_CREEP else ""

    return Trial(values, limits, spread(way=(0.1 * way, way), creep=(0.0, 0.02 * ranges.speed)), exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    tests=("memory",),
    parameters=(
        Parameter("force", "N", 200.0, 0.0, 50000.0, "yield force", linear=True),
        Parameter("way", "m", 3e-4, 1e-6, 0.05, "median travel before a part slips"),
        Parameter("spread", "1", 1.0, 0.1, 4.0, "spread of the travels; 0.1: nearly all parts slip at once"),
        Parameter("creep", "m/s", 0.0, 0.0, 1.0, "speed at which the parts give way while they hold the whole force"),
    ),
    states=PARTS + 1,
    order=1,
    shows="an odd step of the force at each reversal, rounded at low speed; small loops lie inside large ones",
    separate="a slow triangle with small reversals inside a large one, and the same at twice the speed",
    trial=trial,
    general=True,
)
