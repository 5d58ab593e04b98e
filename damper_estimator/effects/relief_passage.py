"""Relief passage beside the path: beyond an opening force oil flows past the elements that produce the force.

    |P| < F_o:  d' = v_0 P / F_o,      beyond:  d' = v_0 + (|P| - F_o) / c,      P = F - F_0,      F = F_path(v - d')

F_0 in N (setting) is the path's force at rest, F_o in N the force beyond it at which the passage opens, per direction,
c in N s/m its slope when it is open, d' in m/s the flow through it over the piston's area; v_0 = 0.1 mm/s.
``pressure_relief`` takes a share of the force away at the same motion. Here the path moves less, which is not the same
if it has a memory: the yield of a magneto-rheological fluid builds up over its own travel. Solved implicitly, second
order in the step (``model.chain``). Source: balance of the flows through parallel passages; Dixon 2008.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values, number
from damper_estimator.effects.dashpot import FIRST
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT, V, X

_LEAK = 1e-4  # m/s at the opening force: a leak that shows would be a hysteresis
_EARLIEST, _LATEST = 0.7, 2.5  # of the recorded force; opening earlier it would round a yield off, as hysteresis does


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """Force of the passage over the flow V through it."""
    for i in range(force.size):
        if kinematics[DT, i] > 0.0:
            rate = kinematics[V, i]
            k = 0 if rate > 0.0 else 2
            opening, slope = parameters[k], parameters[k + 1]
            past = abs(rate) - _LEAK
            held = opening + slope * past if past > 0.0 else opening * abs(rate) / _LEAK
            force[i] += settings[0] + (held if rate > 0.0 else -held)
        else:
            force[i] += settings[0] + FIRST * kinematics[X, i]


def trial(ranges: Ranges) -> Trial:
    """Only a force that is exceeded is visible; a passage that is stiffer than the path hardly opens."""
    slope = ranges.force / ranges.speed
    values = {"opening_rebound": ranges.force, "damping_rebound": slope, "opening_compression": ranges.force,
              "damping_compression": slope, "at_rest": ranges.oil_at_rest}  # fmt: skip
    openings = (_EARLIEST * ranges.force, 6.0 * ranges.force)
    slopes = (0.02 * slope, 300.0 * slope)
    limits = {"opening_rebound": openings, "damping_rebound": slopes,
              "opening_compression": openings, "damping_compression": slopes}  # fmt: skip
    levels = tuple(level * ranges.force for level in (0.8, 1.3, 2.0))
    starts = (
        *spread(opening_rebound=levels, opening_compression=levels),
        {"opening_rebound": levels[1], "damping_compression": 200.0 * slope},
        {"opening_compression": levels[1], "damping_rebound": 200.0 * slope},
    )

    def exclusion(values: Values) -> str:
        late = [number(values, f"opening_{way}") > _LATEST * ranges.force or
                number(values, f"damping_{way}") > 30.0 * slope for way in ("rebound", "compression")]  # fmt: skip
        return "opens beyond the recorded forces" if all(late) else ""

    return Trial(values, limits, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="blow_off",
    tests=("blow-off",),
    parameters=tuple(
        Parameter(f"{name}_{way}", unit, default, low, high, f"{meaning} in {way}")
        for way in ("rebound", "compression")
        for name, unit, default, low, high, meaning in (
            ("opening", "N", 1000.0, 1.0, 1e6, "force beyond that at rest at which the passage opens"),
            ("damping", "N s/m", 3000.0, 1.0, 1e8, "slope of the open passage"),
        )
    ),
    settings=(Setting("at_rest", "N", 0.0, "force of the path at rest, where no oil flows", adds=True),),
    order=2,
    of_oil=True,
    shows="the force rises less beyond a level, whatever the speed at which it reaches it",
    separate="slow and fast strokes that reach the same force",
    trial=trial,
)
