"""Valve that sticks to its seat: it lifts only above a force, later than it should, and then stays open.

    F <- F (1 + g (1 - y)),      tau dy/dt = 1 - y  once |F| > F_l,      -y  once |F| < F_l / 10,      0 before

y is the lift, 0 to 1; g without unit the extra resistance of the stuck valve, F_l in N the force that lifts it, tau in
s. Oil between two flat faces holds a disc until the pressure has pulled it off (squeeze film); it sticks again when the
force has fallen. Setting: side, 1 if the valve of rebound sticks, -1 that of compression, 0 both. States: the lift, and
whether the valve is released; first order in the step. Source: Reynolds' squeeze film between discs; sticking of disc
valves, Lang 1977.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.effects.valve_lag import ONE_SIDE, SIDE
from damper_estimator.signals.layout import DT

_SEATED = 0.1  # of the force that lifts it


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F (1 + g (1 - y))."""
    extra, lifting, side = parameters[0], parameters[1], settings[0]
    for i in range(force.size):
        dt = kinematics[DT, i]
        if dt <= 0.0:
            state[0], state[1] = 0.0, 0.0
        size = 0.0 if side * force[i] < 0.0 else abs(force[i]) * (1.0 + extra * (1.0 - state[0]))
        if size > lifting:
            state[1] = 1.0
        elif size < _SEATED * lifting:
            state[1] = 0.0
        if dt > 0.0:
            state[0] = state[1] + (state[0] - state[1]) * exp(-dt / parameters[2])
        if side * force[i] >= 0.0:
            force[i] *= 1.0 + extra * (1.0 - state[0])


def trial(ranges: Ranges) -> Trial:
    """It lifts at recorded forces, within milliseconds."""
    force = ranges.force
    limits = {"lifting": (0.1 * force, 3.0 * force), "time_constant": (5e-4, 0.05), "extra": (0.0, 2.0)}
    values = {"extra": 0.3, "lifting": 0.5 * force, "time_constant": 0.005}
    starts = spread(lifting=(0.4 * force, 1.2 * force), time_constant=(0.002, 0.012))
    return Trial(values, limits, starts, conditions=ONE_SIDE)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="valve_delay",
    tests=("valve", "history"),
    parameters=(
        Parameter("extra", "1", 0.3, 0.0, 5.0, "extra resistance of the stuck valve, as a share of the force"),
        Parameter("lifting", "N", 200.0, 1.0, 20000.0, "force at which it lifts"),
        Parameter("time_constant", "s", 0.005, 1e-5, 0.2, "time constant of its lifting and of its return"),
    ),
    settings=(SIDE,),
    states=2,
    linear=False,
    order=1,
    shows="after each reversal too much force, until a level has been exceeded; then the usual force",
    separate="the same peak velocity at two frequencies, and a slow triangle that stays below the level",
    trial=trial,
)
