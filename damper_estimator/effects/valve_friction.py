"""Valve whose disc or spool rubs: it stays where it is until the pressure has changed by more than its friction, so
that the force is too high while the pressure rises and too low while it falls, however slowly.

    F <- F + sgn(F) z w,      dz = k d|F|, held within -h and h,      w = F^2 / (F^2 + F_o^2)

h in N is half the distance between opening and closing, k without unit how much more the force rises while the opening
stays as it is, F_o in N the force at which the valve opens. Rebound and compression have a valve each. States: z and
|F| of the one and of the other; first order in the step. Source: stop operator, the complement of play, Visintin 1994;
friction between discs of a stack, Lang 1977.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += sgn(F) z w."""
    friction, steeper, opening = parameters[0], parameters[1], parameters[2]
    for i in range(force.size):
        fresh = kinematics[DT, i] <= 0.0
        whole = force[i]
        for side in range(2):
            carried = max(whole if side == 0 else -whole, 0.0)
            if fresh:
                state[2 * side], state[2 * side + 1] = 0.0, carried
            held = state[2 * side] + steeper * (carried - state[2 * side + 1])
            held = min(max(held, -friction), friction)
            state[2 * side], state[2 * side + 1] = held, carried
            if carried > 0.0:
                share = carried * carried / (carried * carried + opening * opening)
                force[i] += held * share if side == 0 else -held * share


def trial(ranges: Ranges) -> Trial:
    """It opens at recorded forces; a friction of more than the usual force would hold it shut."""
    force = ranges.force
    limits = {"friction": (0.0, force), "steeper": (0.3, 50.0), "opening": (0.05 * force, 2.0 * force)}
    values = {"friction": 0.1 * force, "steeper": 1.0, "opening": 0.3 * force}
    return Trial(values, limits, spread(friction=(0.3 * force,), steeper=(1.0, 10.0)))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="hysteresis",
    tests=("memory", "history"),
    parameters=(
        Parameter("friction", "N", 50.0, 0.0, 20000.0, "half the difference between opening and closing"),
        Parameter("steeper", "1", 1.0, 0.0, 100.0, "additional slope of the force while the valve sticks"),
        Parameter("opening", "N", 200.0, 1.0, 20000.0, "force at which the valve opens"),
    ),
    states=4,
    linear=False,
    order=1,
    shows="more force while the speed rises than while it falls, alike at all frequencies",
    separate="the same peak velocity at two frequencies: a lag opens the loop with frequency, friction does not",
    trial=trial,
)
