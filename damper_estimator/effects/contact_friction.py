"""Dry friction of several contacts, each elastic until it slides: seal, guide and bearing.

    F = F_c mean_k s_k,      ds_k = dx / w_k  while |s_k| < 1,      w_k = w exp(g n_k),      n_k = -1 ... 1

F_c in N is the friction while all contacts slide, w in m the median travel before one slides, g without unit the
spread of the travels, whose logarithms are evenly spaced; nine contacts of equal strength. Unlike that of Dahl, such
friction remembers every reversal: a small loop inside a large one closes. It does not depend on the rate. States: s_k
and the last displacement; second order in the step, from the reversals. Source: Iwan 1966; generalised Maxwell slip of
Al-Bender, Lampaert and Swevers, The generalized Maxwell-slip model, IEEE Trans. Automatic Control 50 (2005), without
its lubrication.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.elastic_slip import PARTS, first_and_ratio, held
from damper_estimator.effects.trial import Ranges, Trial, sliding_soon, spread
from damper_estimator.signals.layout import DT, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_c mean s_k."""
    first, ratio = first_and_ratio(parameters[1], parameters[2])
    for i in range(force.size):
        x, dt = kinematics[X, i], kinematics[DT, i]
        force[i] += parameters[0] * held(state, x, dt, parameters[1], first, ratio, 0.0)


def plausible(values: Values) -> float:
    """The sooner half of the contacts slide, the better."""
    return sliding_soon(number(values, "travel"))


def trial(ranges: Ranges) -> Trial:
    """Contacts slide within tenths of a millimetre."""
    return Trial(
        values={"travel": 2e-4},
        limits={"travel": (1e-5, 1e-3), "spread": (0.2, 2.0), "force": (0.0, 2.0 * ranges.force)},
        starts=spread(force=(0.05 * ranges.force, 0.2 * ranges.force), travel=(5e-5, 4e-4)),
        plausible=plausible,
    )


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="friction",
    tests=("friction step",),
    parameters=(
        Parameter("force", "N", 50.0, 0.0, 10000.0, "friction force while all contacts slide", linear=True),
        Parameter("travel", "m", 2e-4, 1e-6, 0.01, "median travel before a contact slides"),
        Parameter("spread", "1", 1.0, 0.1, 4.0, "spread of the travels; 0.1: nearly all slide at once"),
    ),
    states=PARTS + 1,
    order=2,
    shows="an odd step of the force at each reversal, rounded over a short travel; small loops lie inside large ones",
    separate="a slow triangle with small reversals inside a large one: the travel is the same at any speed",
    trial=trial,
)
