"""Valve that opens and closes late: the force is too high while it opens and too low while it closes.

    F <- F + g (w - y),      tau dy/dt + y = w,      w = sgn(F) (|F| - F_o ln(1 + |F| / F_o))

g without unit, F_o in N, tau in s; tau is c times as long while the valve closes (|w| < |y|). Below the opening force
F_o only the open passages act, without lag; above it the opening follows the pressure with a lag, and the pressure, as
the square of flow over opening, is too high by up to twice the missing opening: g is 0 to 3. Setting: side, 1 for a
valve that carries only rebound, -1 only compression (w = 0 in the other direction), 0 for both alike: piston and foot
have valves of their own. The lag is exact for w linear between samples. States: y and the last w; second order in the
step. Source: first-order valve dynamics, Lozoya-Santos et al., section 2; the disc that lifts with pressure, Lang 1977.
"""

from math import log

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values, number
from damper_estimator.effects.force_lag import lagged
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT

SIDE = Setting("side", "1", 0.0, "1: only in rebound, -1: only in compression, 0: both", lower=-1.0, upper=1.0)
ONE_SIDE = ({"side": 1.0}, {"side": -1.0})
_EARLIEST = 0.4  # of the recorded force, at which a valve opens


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += g (w - y)."""
    opening, closing, side = parameters[1], parameters[3], settings[0]
    for i in range(force.size):
        size, dt = abs(force[i]), kinematics[DT, i]
        wanted = size - opening * log(1.0 + size / opening)
        if force[i] < 0.0:
            wanted = -wanted
        if side * force[i] < 0.0:
            wanted = 0.0
        follows = wanted
        if dt > 0.0:
            lag = parameters[2] / dt
            if abs(wanted) < abs(state[0]):
                lag *= closing
            follows = lagged(wanted, state[1], state[0], lag)
        state[0] = follows
        state[1] = wanted
        force[i] += parameters[0] * (wanted - follows)


def trial(ranges: Ranges) -> Trial:
    """It opens at recorded forces, late by milliseconds; one that is always open delays the whole force, as a mass
    does, unless it explains clearly more than any mass.
    """
    force = ranges.force
    values = {"overshoot": 1.0, "opening": 0.3 * force, "time_constant": 0.002}
    limits = {"opening": (0.05 * force, 5.0 * force), "time_constant": (3e-4, 0.05)}
    starts = spread(opening=(0.3 * force, 1.0 * force), time_constant=(0.001, 0.006, 0.02))

    def exclusion(fitted: Values) -> str:
        alike = number(fitted, "side") == 0.0 and 0.67 < number(fitted, "closing") < 1.5
        always = alike and number(fitted, "opening") < _EARLIEST * force
        return "is always open, alike in both directions: a mass" if always else ""

    return Trial(values, limits, starts, exclusion, imitates="mass", conditions=ONE_SIDE)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="valve_delay",
    tests=("valve",),
    parameters=(
        Parameter("overshoot", "1", 1.0, 0.0, 3.0, "overshoot g per missing share of the opening"),
        Parameter("opening", "N", 200.0, 1.0, 20000.0, "force at which the valve opens"),
        Parameter("time_constant", "s", 0.002, 1e-5, 0.2, "time constant of the valve's opening"),
        Parameter("closing", "1", 1.0, 0.02, 5.0, "time constant of its closing over that of its opening"),
    ),
    settings=(SIDE,),
    states=2,
    linear=False,
    order=2,
    shows="once the valve is open, too much force while it rises and too little while it falls",
    separate="the same peak velocity at two frequencies: the overshoot grows with frequency",
    trial=trial,
)
