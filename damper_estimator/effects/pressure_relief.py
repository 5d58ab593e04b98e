"""Pressure relief: beyond an opening force the damper is softer, per direction.

    F <- F - s_r (P - F_r)  for P > F_r,      F <- F + s_c (-P - F_c)  for P < -F_c,      P = F - F_0

F_0 in N (setting) is the force at rest, F_r, F_c in N are the forces beyond it at which the blow-off valve opens, s
without unit is the share of the further rise that it takes away. The knee is rounded over a tenth of the opening force.
A valve opens on pressure: where the force has a yield or a memory of the way, that is not the same as a speed, at which
``relief`` opens. No state. Source: spring-loaded relief valves, Dixon 2008.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values, number
from damper_estimator.effects.relief import beyond
from damper_estimator.effects.trial import Ranges, Trial, spread

_EARLIEST = 0.2  # of the recorded force
_NOTABLE = 0.03  # of the rise


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F -= s max(|P| - F_o, 0) sgn P, rounded, with P = F - F_0."""
    for i in range(force.size):
        pressed = force[i] - settings[0]
        k = 0 if pressed > 0.0 else 2
        loss = parameters[k] * beyond(abs(pressed), parameters[k + 1])
        force[i] -= loss if pressed > 0.0 else -loss


def trial(ranges: Ranges) -> Trial:
    """The valve opens within the recorded forces, above the lowest ones."""
    lowest = _EARLIEST * ranges.force
    limits = dict.fromkeys(("opening_rebound", "opening_compression"), (lowest, 5.0 * ranges.force))
    values = dict.fromkeys(limits, 0.8 * ranges.force) | {"at_rest": ranges.at_rest}
    levels = (0.4 * ranges.force, 1.4 * ranges.force)

    def exclusion(fitted: Values) -> str:
        sides = [side for side in ("rebound", "compression") if number(fitted, f"share_{side}") > _NOTABLE]
        if sides and all(number(fitted, f"opening_{side}") < 1.05 * lowest for side in sides):
            return "opens at once: a change of the whole curve"
        return ""

    starts = spread(opening_rebound=levels, opening_compression=levels)
    return Trial(values, limits, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="blow_off",
    tests=("blow-off",),
    parameters=(
        Parameter("share_rebound", "1", 0.3, 0.0, 0.95, "share of the further rise that is lost in rebound"),
        Parameter("opening_rebound", "N", 1000.0, 1.0, 50000.0, "force at which the valve opens in rebound"),
        Parameter("share_compression", "1", 0.3, 0.0, 0.95, "share of the further rise that is lost in compression"),
        Parameter("opening_compression", "N", 1000.0, 1.0, 50000.0, "force at which the valve opens in compression"),
    ),
    settings=(Setting("at_rest", "N", 0.0, "force at rest, where no pressure opens the valve", adds=True),),
    linear=False,
    shows="above a certain force the damper yields: peaks are lower than the model's, whatever the speed",
    separate="forces well above and below the opening force, reached at different speeds or currents",
    trial=trial,
)
