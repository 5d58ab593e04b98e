"""Hysteresis of the oil's compressibility as a constant times acceleration.

    F = k a,      k <= 0

k in N s^2/m, a in m/s^2. Compressed oil makes the force lag the velocity, F(v - tau a) = F(v) - c tau a: the
constant is negative (a positive one would be a mass). No state. Source: Carrera Akutain et al., section 3,
filtered mode.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import A


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += k a."""
    for i in range(force.size):
        force[i] += parameters[0] * kinematics[A, i]


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="oil_compressibility",
    tests=("series",),
    parameters=(Parameter("constant", "N s^2/m", -1.0, -500.0, 0.0, "force per acceleration", linear=True),),
    shows="the F-v loop opens with frequency: more force while decelerating than while accelerating",
    separate="the same peak velocity at two frequencies: a time lag grows with the frequency",
    trial=None,
)
