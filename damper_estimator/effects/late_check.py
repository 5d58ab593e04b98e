"""Check valve that closes late: after a reversal oil still flows back through it, and the force builds up late.

    F <- F_0 + (F - F_0) / (1 + k y)^2,      y = (1 - z sgn v) / 2,      tau dz/dt = sgn v - z

y is the lift of the valve, 1 at the reversal; z without unit the direction of the flow, as the valve follows it; k
without unit its passage when open over that of the damping valve, tau in s, F_0 in N (setting) the force at rest. The
valve feeds the chamber behind the piston and must close before the pressure there can rise; until then the flow divides
over both passages, and the pressure falls with the square of their sum. Setting: side, 1 if the force of rebound builds
up late, -1 that of compression, 0 both alike. State: z; first order in the step. Source: orifices in parallel; check
valves of hydraulic dampers, Lang 1977.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import KEPT_AT_REST, Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.effects.valve_lag import ONE_SIDE, SIDE
from damper_estimator.signals.layout import DT, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) / (1 + k y)^2."""
    passage, side, still = parameters[0], settings[0], settings[1]
    for i in range(force.size):
        v, dt = kinematics[V, i], kinematics[DT, i]
        way = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
        if dt <= 0.0:
            state[0] = way
        state[0] = way + (state[0] - way) * exp(-max(dt, 0.0) / parameters[1])
        if side * v >= 0.0:
            both = 1.0 + passage * 0.5 * (1.0 - state[0] * way)
            force[i] = still + (force[i] - still) / (both * both)


def trial(ranges: Ranges) -> Trial:
    """It closes within milliseconds to tenths of a second."""
    limits = {"passage": (0.0, 20.0), "time_constant": (1e-3, 0.1)}
    values = {"passage": 1.0, "time_constant": 0.01, "at_rest": ranges.at_rest}
    starts = spread(passage=(0.5, 4.0), time_constant=(0.004, 0.025))
    return Trial(values, limits, starts, conditions=ONE_SIDE)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="valve_delay",
    tests=("history",),
    parameters=(
        Parameter("passage", "1", 1.0, 0.0, 100.0, "passage of the open check valve over that of the damping valve"),
        Parameter("time_constant", "s", 0.01, 1e-5, 1.0, "time constant of its closing"),
    ),
    settings=(SIDE, KEPT_AT_REST),
    states=1,
    linear=False,
    order=1,
    shows="after each reversal too little force, for the same time at any speed",
    separate="the same stroke slow and fast: the force is late by the same time; behind a play, by the same way",
    trial=trial,
)
