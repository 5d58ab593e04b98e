"""Hydraulic stop: damping that begins near an end of the stroke and grows towards the end, beside a return spring.

    F = c_b d_b v g(v) / s - k_b d_b,  d_b = max(x_b - x, 0),  g = 1 while closing (v < 0), r on the return
    F = c_t d_t v g(v) / s + k_t d_t,  d_t = max(x - x_t, 0),  g = 1 while extending (v > 0), r on the return

x in m (positive in extension), v in m/s, c in N s/m (at a depth s into the stop), s in m (setting), r without unit
(share of the damping on the return; 0 with an open check valve), k in N/m. With a setting speed v_s in m/s the
clearance is an orifice: c is the damping at that speed, and is multiplied by |v| / v_s. No state. Source: hydraulic
bump and rebound stops with a clearance that narrows, and the spring that returns their piston, Dixon 2008.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values, number
from damper_estimator.effects.trial import Ranges, Trial, leaves_no_middle
from damper_estimator.signals.layout import V, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += (bump stop + rebound stop)."""
    for i in range(force.size):
        x, v = kinematics[X, i], kinematics[V, i]
        bump = max(parameters[1] - x, 0.0)
        rebound = max(x - parameters[3], 0.0)
        force[i] += parameters[6] * rebound - parameters[5] * bump
        if v > 0.0:
            bump = bump * parameters[4]
        else:
            rebound = rebound * parameters[4]
        share = abs(v) / settings[1] if settings[1] > 0.0 else 1.0
        force[i] += (parameters[0] * bump + parameters[2] * rebound) / settings[0] * share * v


def trial(ranges: Ranges) -> Trial:
    """A stop leaves a third of the recorded stroke free: damping that changes over more of it is a groove."""
    depth = ranges.stroke / 3.0
    limits = dict(zip(("bump_position", "rebound_position"), ranges.ends, strict=True))
    starts = tuple(
        {"bump_position": ranges.compression + share * depth, "rebound_position": ranges.extension - share * depth,
         "way_back": back}
        for share in (0.3, 0.6, 0.9, 1.7) for back in (0.1, 0.9)
    )  # fmt: skip

    def exclusion(fitted: Values) -> str:
        bump, rebound = number(fitted, "bump_position"), number(fitted, "rebound_position")
        ways = {"bump": max(bump - ranges.compression, 0.0), "rebound": max(ranges.extension - rebound, 0.0)}
        low, high = (
            way * (number(fitted, f"{name}_damping") * ranges.speed / depth + number(fitted, f"{name}_stiffness"))
            for name, way in ways.items()
        )
        none = leaves_no_middle(bump, rebound, (low, high), ranges)
        return "acts all over the stroke: a groove, or a spring" if none else ""

    return Trial({"depth": depth, **starts[0]}, limits, starts[1:], exclusion, conditions=({"speed": ranges.speed},))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="end_stop",
    beside_oil=True,
    tests=("stops", "position"),
    parameters=(
        Parameter("bump_damping", "N*s/m", 0.0, 0.0, 1e6, "damping of the bump stop at the depth", linear=True),
        Parameter("bump_position", "m", -0.05, -0.5, 0.5, "displacement at which the bump stop begins"),
        Parameter("rebound_damping", "N*s/m", 0.0, 0.0, 1e6, "damping of the rebound stop at the depth", linear=True),
        Parameter("rebound_position", "m", 0.05, -0.5, 0.5, "displacement at which the rebound stop begins"),
        Parameter("way_back", "1", 0.2, 0.0, 1.0, "share of the damping on the return"),
        Parameter("bump_stiffness", "N/m", 0.0, 0.0, 1e6, "spring of the bump stop", linear=True),
        Parameter("rebound_stiffness", "N/m", 0.0, 0.0, 1e6, "spring of the rebound stop", linear=True),
    ),
    settings=(
        Setting("depth", "m", 0.02, "depth into a stop at which its damping is stated", lower=1e-4),
        Setting("speed", "m/s", 0.0, "speed at which it is stated, if it grows with it; 0 if not", lower=0.0),
    ),
    shows="near an end of the stroke the force grows with velocity far more than in the middle, less on the return",
    separate="the same velocities in the middle and near the ends of the stroke",
    trial=trial,
)
