"""Inertia of the oil and the disc in a valve: it acts while the valve is open.

    F = m a w(v),      w = 1 / (1 + (v_o / |v|)^8),      m = m_r for v > 0, m_c for v <= 0

m in kg, v_o in m/s the speed at which the valve opens. A valve that carries oil must accelerate it, and its disc: more
force while the flow rises, less while it falls. No state. Source: the second valve dynamics of Lang 1977; Newton.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import A, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += m a w(v)."""
    for i in range(force.size):
        v = kinematics[V, i]
        mass = parameters[0] if v > 0.0 else parameters[1]
        square = (v / parameters[2]) * (v / parameters[2])
        share = square * square * (square * square)
        force[i] += mass * kinematics[A, i] * (share / (1.0 + share))


_EARLIEST = 0.08  # of the recorded speed, at which a valve opens


def trial(ranges: Ranges) -> Trial:
    """The valve opens within the recorded speeds; one that is always open, alike in both directions, is a mass, unless
    it explains clearly more than any mass.
    """
    speed = ranges.speed
    masses = dict.fromkeys(("mass_rebound", "mass_compression"), (0.0, 2.0 * ranges.most_mass))
    starts = spread(opening=(0.1 * speed, 0.3 * speed, 0.5 * speed))

    def exclusion(values: Values) -> str:
        rebound, compression, opening = (number(values, name) for name in (*masses, "opening"))
        alike = abs(rebound - compression) < 0.25 * (rebound + compression)
        return "is always open, alike in both directions: a mass" if alike and opening < 0.15 * speed else ""

    limits = masses | {"opening": (_EARLIEST * speed, 0.8 * speed)}
    return Trial({"opening": 0.2 * speed}, limits, starts, exclusion, imitates="mass")


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="valve_delay",
    tests=("valve",),
    parameters=(
        Parameter("mass_rebound", "kg", 1.0, 0.0, 1000.0, "equivalent mass at the rod in rebound", linear=True),
        Parameter("mass_compression", "kg", 1.0, 0.0, 1000.0, "equivalent mass at the rod in compression", linear=True),
        Parameter("opening", "m/s", 0.1, 1e-3, 5.0, "speed at which the valve opens"),
    ),
    shows="above an opening speed more force while the speed rises, less while it falls; nothing at the reversals",
    separate="the same peak velocity at two frequencies: the overshoot grows with frequency",
    trial=trial,
)
