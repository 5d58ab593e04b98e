"""Spring whose force relaxes: a viscoelastic seal, bush or fluid beside the damper.

    dF/dt = k v - F / tau

k in N/m, tau in s. Fast motion meets a spring, slow motion a damping of k tau. v is taken as linear between samples;
the relaxation is exact for it, at any step. States: F and the last k tau v; second order in the step. Source: Maxwell
element, Lion and Loose 2002.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.force_lag import lagged
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += relaxing spring."""
    steady = parameters[0] * parameters[1]
    for i in range(force.size):
        dt, wanted = kinematics[DT, i], steady * kinematics[V, i]
        state[0] = lagged(wanted, state[1], state[0], parameters[1] / dt) if dt > 0.0 else 0.0
        state[1] = wanted
        force[i] += state[0]


def trial(ranges: Ranges) -> Trial:
    """It relaxes within the strokes of a damper: faster is damping, slower a spring."""
    stiffness = ranges.force / ranges.stroke
    limits = {"stiffness": (0.0, 50.0 * stiffness), "relaxation": (0.01, 0.6)}
    return Trial({"stiffness": stiffness, "relaxation": 0.1}, limits, spread(relaxation=(0.03, 0.3)))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    tests=("memory",),
    parameters=(
        Parameter("stiffness", "N/m", 2e4, 0.0, 1e8, "stiffness in fast motion", linear=True),
        Parameter("relaxation", "s", 0.1, 1e-4, 10.0, "time constant of the relaxation"),
    ),
    states=2,
    order=2,
    shows="a spring in fast motion that is none in slow motion: the force decays while the damper stands",
    separate="a fast step with a hold after it: the force relaxes, that of a spring or of gas remains",
    trial=trial,
)
