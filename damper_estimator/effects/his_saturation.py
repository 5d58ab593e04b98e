"""Diagonal band that limits the force: the open high-pressure valves of an interconnected suspension's damper.

    F <- min(max(F, F_min), F_max)
    F_max = max(c_1 (v - v_B) + F_B, y_1)             for v > v_B
            max((c_2 |a| + c_3)(v - v_B) + F_B, y_1)  else                  (2)
    F_min = min(c_4 (v - v_G) + F_G, y_2)             for v <= v_G
            min((c_5 |a| + c_6)(v - v_G) + F_G, y_2)  else                  (3)

v in m/s, a in m/s^2, forces in N, c_1, c_3, c_4, c_6 in N s/m, c_2, c_5 in N s^3/m^2. The slopes c_2 |a| +
c_3 and c_5 |a| + c_6 are kept at or above zero, where large accelerations would invert the band. No state.
Source: HIS paper, eqs. (2), (3), (5).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import A, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F clipped to the band; parameters of the upper bound, then of the lower."""
    for i in range(force.size):
        v, a = kinematics[V, i], abs(kinematics[A, i])
        away = v - parameters[0]
        slope = parameters[2] if away > 0.0 else max(parameters[3] * a + parameters[4], 0.0)
        upper = max(slope * away + parameters[1], parameters[5])
        away = v - parameters[6]
        slope = parameters[8] if away <= 0.0 else max(parameters[9] * a + parameters[10], 0.0)
        lower = min(slope * away + parameters[7], parameters[11])
        # As published, the upper bound is applied last.
        force[i] = lower if force[i] < lower else min(force[i], upper)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="blow_off",
    tests=("blow-off",),
    parameters=(
        Parameter("knee_velocity_rebound", "m/s", 0.35, 0.0, 5.0, "v_B"),
        Parameter("knee_force_rebound", "N", 4231.0, 0.0, 50000.0, "F_B"),
        Parameter("slope_rebound", "N s/m", 5919.0, 0.0, 1e5, "c_1"),
        Parameter("closing_rebound", "N s^3/m^2", -96.0, -5000.0, 0.0, "c_2"),
        Parameter("closing_rest_rebound", "N s/m", 5973.0, 0.0, 1e5, "c_3"),
        Parameter("level_rebound", "N", 326.0, -5000.0, 5000.0, "y_1, the level of C-D"),
        Parameter("knee_velocity_compression", "m/s", -0.26, -5.0, 0.0, "v_G"),
        Parameter("knee_force_compression", "N", -1957.0, -50000.0, 0.0, "F_G"),
        Parameter("slope_compression", "N s/m", 8010.0, 0.0, 1e5, "c_4"),
        Parameter("closing_compression", "N s^3/m^2", -501.0, -5000.0, 0.0, "c_5"),
        Parameter("closing_rest_compression", "N s/m", 11299.0, 0.0, 1e5, "c_6"),
        Parameter("level_compression", "N", -86.0, -5000.0, 5000.0, "y_2, the level of H-I"),
    ),
    linear=False,
    shows="the force never leaves a diagonal band in F-v",
    separate="speeds well above and below the knees",
    trial=None,
)
