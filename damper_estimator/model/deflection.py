"""The deflection of a compliance in front of a path, solved for at every sample.

    F_compliance(d, r) = F_path(v - r),      r = D + w (D - D_before),      D = (d - d_before) / dt

with w = dt / (dt + dt_before), at most 0.7: the backward differentiation formula of second order for uneven steps (Gear
1971), stable for any stiffness; w = 0 (backward Euler) on the first step, r = 0 on the first sample. The left side
rises with d and the right side falls, so the root is unique; where a path's force falls with velocity there may be
none, and the deflection stays as it was for that step. The search starts from what the last two rates predict and from
the last slope, continues with secants and bisects if a secant leaves the bracket or hardly reduces the imbalance.
"""

import numpy as np

from damper_estimator.compiled import inlined

# The states of a series operation precede those of its kernel: deflection, its mean rate over the last step, the length
# of that step, the slope of the imbalance, and the mean rate over the step before.
DEFLECTION, RATE, STEP, SLOPE, BEFORE = range(5)
SERIES_STATES = 5
# Columns of a solver's row: the trial deflection, the point before it, and the bracket.
TRIAL, LAST, G_LAST, LOW, HIGH, COUNT = range(6)
SOLVER_COLUMNS = 6
_ITERATIONS = 80
_CLOSED = 1e-15  # m, width of a bracket at which the search ends
_FURTHEST = 0.2  # m from where the step began: beyond it there is no balance
_MOST_AHEAD = 0.7  # w: the formula is stable for steps that grow by up to 2.4


@inlined
def mean_rate(step, saved, first, deflection):
    """Mean rate of the deflection over this step, m/s."""
    return (deflection - saved[first + DEFLECTION]) / step if step > 0.0 else 0.0


@inlined
def rate_of(step, saved, first, deflection):
    """Rate of the deflection at the end of this step, m/s, from this step and the one before."""
    mean, before = mean_rate(step, saved, first, deflection), saved[first + STEP]
    if step <= 0.0 or before <= 0.0:
        return mean
    return mean + min(step / (step + before), _MOST_AHEAD) * (mean - saved[first + RATE])


@inlined
def secant_slope(solver, deflection, g, slope):
    """Slope of the imbalance between this point and the last one; ``slope`` if undefined."""
    if solver[COUNT] > 0.0 and deflection != solver[LAST]:
        secant = (g - solver[G_LAST]) / (deflection - solver[LAST])
        if secant > 0.0:
            return secant
    return slope


@inlined
def balanced(solver, g, tolerance, slope, before):
    """True if the trial is accepted; otherwise sets the next trial."""
    if abs(g) <= tolerance or solver[COUNT] >= _ITERATIONS:
        return True
    here = solver[TRIAL]
    if g > 0.0:
        solver[HIGH] = here
    else:
        solver[LOW] = here
    width = solver[HIGH] - solver[LOW]
    if width < _CLOSED:
        return True
    step = -g / secant_slope(solver, here, g, slope)
    bracketed = width < np.inf
    slow = solver[COUNT] > 0.0 and abs(g) > 0.5 * abs(solver[G_LAST])
    if not bracketed and slow:
        step *= 2.0  # one side of the bracket is missing, and steps hardly help: rather too far than too short
    trial = here + step
    if bracketed and (slow or not solver[LOW] < trial < solver[HIGH]):
        trial = 0.5 * (solver[LOW] + solver[HIGH])
    if abs(trial - before) > _FURTHEST:  # without a balance the compliance stays as it was for this step
        solver[TRIAL], solver[COUNT] = before, _ITERATIONS
        return False
    solver[LAST], solver[G_LAST] = here, g
    solver[TRIAL] = trial
    solver[COUNT] += 1.0
    return False
