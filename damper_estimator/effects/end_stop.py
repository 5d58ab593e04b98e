"""Bump stop and top-out: progressive springs beyond a stroke position.

    F = -k_b (x_b - x)^p  for x < x_b,      F = k_t (x - x_t)^p  for x > x_t

x in m (positive in extension), k in N/m^p, p without unit (setting). The bump stop pushes the rod out
(negative force), the top-out holds it back. No state. Source: Dixon 2008, progressive bump stops.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values, number
from damper_estimator.effects.trial import Ranges, Trial, leaves_no_middle
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += top-out - bump stop."""
    for i in range(force.size):
        x = kinematics[X, i]
        if x < parameters[1]:
            force[i] -= parameters[0] * (parameters[1] - x) ** settings[0]
        if x > parameters[3]:
            force[i] += parameters[2] * (x - parameters[3]) ** settings[0]


def trial(ranges: Ranges) -> Trial:
    """Long bump stops of foam touch before the middle, but a spring over more than two thirds of the recorded stroke is
    no stop.
    """
    limits = dict(zip(("bump_position", "top_out_position"), ranges.ends, strict=True))
    depths = (0.1, 0.3, 0.6, 0.9)
    starts = tuple(
        {name: low + (depth if name.startswith("bump") else 1.0 - depth) * (high - low)
         for name, (low, high) in limits.items()}
        for depth in depths
    )  # fmt: skip

    def exclusion(fitted: Values) -> str:
        bump, top_out = number(fitted, "bump_position"), number(fitted, "top_out_position")
        low = number(fitted, "bump_stiffness") * max(bump - ranges.compression, 0.0) ** number(fitted, "exponent")
        high = number(fitted, "top_out_stiffness") * max(ranges.extension - top_out, 0.0) ** number(fitted, "exponent")
        return "acts all over the stroke: a spring" if leaves_no_middle(bump, top_out, (low, high), ranges) else ""

    return Trial(starts[0], limits, starts[1:], exclusion, conditions=({"exponent": 3.0},))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="end_stop",
    beside_oil=True,
    tests=("stops",),
    parameters=(
        Parameter("bump_stiffness", "N/m^p", 0.0, 0.0, 1e9, "stiffness of the bump stop", linear=True),
        Parameter("bump_position", "m", -0.05, -0.5, 0.5, "displacement at which the bump stop touches"),
        Parameter("top_out_stiffness", "N/m^p", 0.0, 0.0, 1e9, "stiffness of the top-out", linear=True),
        Parameter("top_out_position", "m", 0.05, -0.5, 0.5, "displacement at which the top-out touches"),
    ),
    settings=(Setting("exponent", "1", 2.0, "1 linear, 2 progressive", lower=1.0, upper=4.0),),
    shows="the force rises steeply near the ends of the stroke, at any velocity",
    separate="a slow stroke into the stops",
    trial=trial,
)
