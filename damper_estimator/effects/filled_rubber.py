"""Mount of filled rubber in series with the damper: its dry friction makes it stiff and lossy in small motions.

    F = k d + F_f,      F_f = F_s + (d - d_s) / (d_2 (1 - s F_s / f) + |d - d_s|) (f - s F_s),      F = F_path(v - d')

k in N/m, d in m; f in N the largest friction, d_2 in m the travel over which half of it builds up from zero. d_s and
F_s are deflection and friction at the last reversal, s the direction since then. States: friction, deflection, d_s,
F_s and s. Solved implicitly (``model.chain``); first order in the step where the deflection turns round. Source: Berg
1998, the elastic and friction forces of a rubber spring.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += k d + F_f."""
    stiffness, largest, travel = parameters[0], parameters[1], parameters[2]
    for i in range(force.size):
        d = kinematics[X, i]
        if kinematics[DT, i] <= 0.0:
            state[0], state[2], state[3], state[4] = 0.0, d, 0.0, 1.0
        else:
            direction = 1.0 if d >= state[1] else -1.0
            if direction != state[4]:
                state[2], state[3], state[4] = state[1], state[0], direction
            moved, before = abs(d - state[2]), direction * state[3]
            left = max(largest - before, 0.0)
            share = moved / (travel * (1.0 - before / max(largest, 1e-9)) + moved + 1e-15)
            state[0] = state[3] + direction * share * left
        state[1] = d
        force[i] += stiffness * d + state[0]


def trial(ranges: Ranges) -> Trial:
    """A mount deflects by at most a twentieth of the stroke; its friction is a share of what it carries."""
    least = ranges.least_stiffness
    limits = {"stiffness": (least, 1000000000.0), "dry": (0.0, ranges.force), "travel": (1e-5, 1e-3)}
    values = {"stiffness": 4.0 * least, "dry": 0.05 * ranges.force, "travel": 5e-5}
    return Trial(values, limits, spread(stiffness=(10.0 * least, 40.0 * least)))


EFFECT = Effect(
    kernel=kernel,
    kind="series",
    phenomenon="mount_compliance",
    tests=("series",),
    parameters=(
        Parameter("stiffness", "N/m", 2e6, 5e4, 1e9, "stiffness without friction"),
        Parameter("dry", "N", 20.0, 0.0, 20000.0, "largest friction of the filler"),
        Parameter("travel", "m", 1e-4, 1e-6, 1e-2, "over which half of the friction builds up"),
    ),
    states=5,
    order=1,
    shows="the force turns round over a travel, alike in both directions, with a loss that hardly depends on frequency",
    separate="impedance of the mount on its own",
    trial=trial,
)
