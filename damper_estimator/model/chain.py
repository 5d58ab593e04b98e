"""The force chain as a flat program, and the one loop that runs it, in blocks and live.

Every entry of a model becomes one operation on registers: forces (one per path) and motions (the given one, and a
private copy per path that changes it). A chain with a series effect runs sample by sample: the deflection d of the
compliance before a path is solved for,

    F_compliance(d, r) = F_path(v - r),      r = (d - d_before) / dt      (backward Euler; r = 0 on the first sample)

The left side rises with d and the right side falls, so the root is single; it is bracketed, then found by the Illinois
variant of regula falsi. Kernels are called through function pointers: the loop is compiled once for all models.
"""

import numpy as np

from damper_estimator.compiled import COMPILED, compiled
from damper_estimator.signals.layout import DT, A, V, X

RUN, ENTER, LEAVE, SERIES, SOLVE = range(5)
# Columns of the table of operations: what it does, its kernel, the matching SERIES or SOLVE row, its own registers and
# its parent's, and which part of the parameters, settings and states belongs to it.
CODE, KERNEL, PARTNER, MOTION, MOTION_UP, FORCE, FORCE_UP, P0, P1, S0, S1, Z0, Z1 = range(13)
COLUMNS = 13
# Columns of a solver's row: the trial deflection, the bracket, and how far the search is.
TRIAL, LOW, G_LOW, HIGH, G_HIGH, WIDTH, PHASE, COUNT = range(8)
SOLVER_COLUMNS = 8
FIRST, EXPANDING, SHRINKING = 0.0, 1.0, 2.0
_TOLERANCE = 1e-9  # of the force, and times 100 N
_ITERATIONS = 80


@compiled
def run(kernels, table, parameters, settings, kinematics, motions, forces, state, solvers, trace):
    """Runs the program on a block.

    Args:
        kernels: list of kernels.
        table: (m, 13) int64, one operation per row.
        parameters, settings: flat float64 arrays.
        kinematics: (8, n); unchanged.
        motions: (k, 8, n) registers 1 to k, for paths that change the motion.
        forces: (l, n) registers; register 0 holds the result.
        state: flat float64 array, carried.
        solvers: (m, 8) work space of the series operations; (0, 8) where there is none.
        trace: (m, n) to receive what each operation changed of the force, or (0, 0).
    """
    forces[0, :] = 0.0
    if solvers.shape[0] == 0:
        j = 0
        while j < table.shape[0]:
            _operate(kernels, table, j, parameters, settings, kinematics, motions, forces, state, trace)
            j += 1
        return
    column = np.empty((kinematics.shape[0], 1))
    inner = np.empty((motions.shape[0], kinematics.shape[0], 1))
    force = np.zeros((forces.shape[0], 1))
    saved = np.empty_like(state)
    mark = np.zeros((trace.shape[0], 1))
    for i in range(kinematics.shape[1]):
        column[:, 0] = kinematics[:, i]
        force[0, 0] = 0.0
        j = 0
        while j < table.shape[0]:
            if table[j, CODE] == SERIES:
                _begin_series(table, j, column, inner, force, state, saved, solvers[j])
            elif table[j, CODE] == SOLVE:
                j = _advance_series(
                    kernels, table, j, parameters, settings, column, inner, force, state, saved, solvers, mark
                )
            else:
                _operate(kernels, table, j, parameters, settings, column, inner, force, state, mark)
            j += 1
        forces[0, i] = force[0, 0]
        if trace.shape[0] > 0:
            trace[:, i] = mark[:, 0]


@compiled
def _operate(kernels, table, j, parameters, settings, kinematics, motions, forces, state, trace):
    """One operation other than a series."""
    own = table[j, FORCE]
    if table[j, CODE] == ENTER:
        forces[own, :] = 0.0
        if table[j, MOTION] != table[j, MOTION_UP]:
            above = table[j, MOTION_UP]
            motions[table[j, MOTION] - 1, :, :] = kinematics if above == 0 else motions[above - 1]
    elif table[j, CODE] == LEAVE:
        forces[table[j, FORCE_UP], :] += forces[own]
    else:
        if trace.shape[0] > 0:
            trace[j, :] = -forces[own]
        level = table[j, MOTION]
        kernels[table[j, KERNEL]](
            parameters[table[j, P0] : table[j, P1]],
            settings[table[j, S0] : table[j, S1]],
            kinematics if level == 0 else motions[level - 1],
            state[table[j, Z0] : table[j, Z1]],
            forces[own],
        )
        if trace.shape[0] > 0:
            trace[j, :] += forces[own]


@compiled
def _begin_series(table, j, column, motions, force, state, saved, solver):
    """Keeps the states from before this sample and tries the deflection as it was."""
    first, last = table[j, Z0], table[table[j, PARTNER], Z1]
    saved[first:last] = state[first:last]
    solver[TRIAL] = state[first]
    solver[PHASE] = FIRST
    solver[COUNT] = 0.0
    above = table[j, MOTION_UP]
    given = column if above == 0 else motions[above - 1]
    solver[WIDTH] = max(abs(given[V, 0]) * given[DT, 0], 1e-7)
    _try_deflection(table, j, given, motions, force, saved, solver)


@compiled
def _try_deflection(table, j, given, motions, force, saved, solver):
    """Sets the path's motion to what the trial deflection leaves of the given one, and its force to zero."""
    own = motions[table[j, MOTION] - 1]
    own[:, :] = given
    own[X, 0] = given[X, 0] - solver[TRIAL]
    own[V, 0] = given[V, 0] - _rate(given, saved[table[j, Z0]], solver[TRIAL])
    force[table[j, FORCE], 0] = 0.0


@compiled
def _rate(given, before, deflection):
    """Rate of the deflection over this step, m/s."""
    return (deflection - before) / given[DT, 0] if given[DT, 0] > 0.0 else 0.0


@compiled
def _advance_series(kernels, table, end, parameters, settings, column, motions, force, state, saved, solvers, mark):
    """Compares compliance and path at the trial; returns ``end`` when they balance, else where to run the path again."""
    begin = table[end, PARTNER]
    solver = solvers[begin]
    first, last = table[begin, Z0], table[end, Z1]
    above = table[begin, MOTION_UP]
    given = column if above == 0 else motions[above - 1]
    path_force = force[table[begin, FORCE], 0]
    deflected = given.copy()
    deflected[X, 0] = solver[TRIAL]
    deflected[V, 0] = _rate(given, saved[first], solver[TRIAL])
    deflected[A, 0] = 0.0
    compliance = np.zeros(1)
    kernels[table[begin, KERNEL]](
        parameters[table[begin, P0] : table[begin, P1]],
        settings[table[begin, S0] : table[begin, S1]],
        deflected,
        state[first + 1 : table[begin, Z1]],
        compliance,
    )
    if _balanced(solver, compliance[0] - path_force, _TOLERANCE * (100.0 + abs(path_force))):
        state[first] = solver[TRIAL]
        force[table[begin, FORCE_UP], 0] += path_force
        if mark.shape[0] > 0:
            mark[begin : end + 1, 0] = 0.0
            mark[begin, 0] = path_force
        return end
    state[first:last] = saved[first:last]
    _try_deflection(table, begin, given, motions, force, saved, solver)
    return begin


@compiled
def _balanced(solver, g, tolerance):
    """True when the trial is accepted; otherwise the next trial is proposed."""
    if abs(g) <= tolerance or solver[COUNT] >= _ITERATIONS:
        return True
    solver[COUNT] += 1.0
    if solver[PHASE] == FIRST:
        solver[PHASE] = EXPANDING
    elif solver[PHASE] == EXPANDING:
        solver[LOW], solver[G_LOW] = solver[HIGH], solver[G_HIGH]
        if g * solver[G_LOW] < 0.0:
            solver[PHASE] = SHRINKING
    elif g * solver[G_HIGH] < 0.0:
        solver[LOW], solver[G_LOW] = solver[HIGH], solver[G_HIGH]
    else:
        solver[G_LOW] *= 0.5
    solver[HIGH], solver[G_HIGH] = solver[TRIAL], g
    if solver[PHASE] == EXPANDING:
        solver[TRIAL] = solver[HIGH] - solver[WIDTH] if g > 0.0 else solver[HIGH] + solver[WIDTH]
        solver[WIDTH] *= 2.0
        return False
    if abs(solver[HIGH] - solver[LOW]) < 1e-15:
        return True
    share = solver[G_HIGH] / (solver[G_HIGH] - solver[G_LOW])
    solver[TRIAL] = solver[HIGH] - share * (solver[HIGH] - solver[LOW])
    return False


def kernel_list(kernels: list) -> list:
    """The kernels as a list that the compiled loop can call; a plain list where nothing is compiled."""
    if not COMPILED:
        return kernels
    from numba import float64, types
    from numba.typed import List

    vector = float64[::1]
    signature = types.void(vector, vector, float64[:, ::1], vector, vector)
    pointers = List.empty_list(types.FunctionType(signature))
    for kernel in kernels:
        kernel.compile(signature)
        pointers.append(kernel)
    return pointers
