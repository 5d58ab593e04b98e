"""Force-velocity curve through given points, straight between them and beyond the outermost.

    F = F_k + (F_{k+1} - F_k) (v - v_k) / (v_{k+1} - v_k),      v_k <= v < v_{k+1}

Settings: knots v_k in m/s, strictly increasing. Parameters: one force F_k in N per knot. No state. Source:
the look-up curve of measured peaks in Gao et al., section 3.1, and of any damper data sheet.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += curve(v)."""
    last = settings.size - 2
    for i in range(force.size):
        v = kinematics[V, i]
        low, high = 0, last
        while low < high:
            middle = (low + high + 1) // 2
            if settings[middle] <= v:
                low = middle
            else:
                high = middle - 1
        share = (v - settings[low]) / (settings[low + 1] - settings[low])
        force[i] += parameters[low] + share * (parameters[low + 1] - parameters[low])


KNOTS = (-1.0, -0.5, -0.2, -0.1, -0.05, -0.02, 0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)

EFFECT = Effect(
    kernel=kernel,
    kind="source",
    parameters=(Parameter("force", "N", 0.0, -50000.0, 50000.0, "force at the knot", linear=True, size="velocity"),),
    settings=(Setting("velocity", "m/s", KNOTS, "knots of the curve, at least two", increasing=True),),
    shows="one line in F-v at any frequency and amplitude",
)
