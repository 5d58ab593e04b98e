"""Passes the force of its path in one direction only: separate parameters for rebound and compression.

    F <- F  for v > 0 (direction 1),      F <- F  for v <= 0 (direction -1),      0 otherwise

No parameters, no state. Source: Lozoya-Santos et al., eq. (12).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Setting
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F = 0 in the other direction."""
    for i in range(force.size):
        if (kinematics[V, i] > 0.0) != (settings[0] > 0.0):
            force[i] = 0.0


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    settings=(Setting("direction", "1", 1.0, "1 rebound, -1 compression", lower=-1.0, upper=1.0),),
    shows="rebound and compression follow different laws",
)
