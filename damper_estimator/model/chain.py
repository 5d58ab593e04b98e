"""The force chain as a flat program, and the one loop that runs it, in blocks and live.

Every entry of a model becomes one operation on registers: forces (one per path) and motions (the input motion, and a
private copy for each path that changes it). A chain with a series effect runs sample by sample: the deflection of the
compliance in front of a path is searched for, see ``model.deflection``. Kernels are called by their addresses, and so
are the loops: compiled once for all models and callers. Modifiers that scale the compliance act on its force, with the
input motion of the series: command, temperature and position of the damper.
"""

import numpy as np

from damper_estimator.compiled import borrowed, compiled, inlined
from damper_estimator.model.deflection import (
    BEFORE,
    COUNT,
    DEFLECTION,
    HIGH,
    LOW,
    RATE,
    SERIES_STATES,
    SLOPE,
    SOLVER_COLUMNS,
    STEP,
    TRIAL,
    balanced,
    mean_rate,
    rate_of,
    secant_slope,
)
from damper_estimator.model.kernels import BLOCK_LOOP, SAMPLE_LOOP, by_address, call_kernel, part
from damper_estimator.signals.layout import DT, STROKE, V, X

RUN, ENTER, LEAVE, SERIES, SOLVE, SCALE, CHANNEL = range(7)
# Columns of the table of operations: operation code, kernel, matching SERIES or SOLVE row, registers of the operation
# and of its parent, and its range of the parameters, settings and states.
CODE, KERNEL, PARTNER, MOTION, MOTION_UP, FORCE, FORCE_UP, P0, P1, S0, S1, Z0, Z1 = range(13)
COLUMNS = 13
_TOLERANCE = 1e-9  # of the force, and times 100 N
_START_SLOPE = 1e6  # N/m, for the first step


@compiled
def block_loop(functions, table, parameters, settings, kinematics, motions, forces, state, solvers, trace):
    """``run`` without a series: every operation on the whole block."""
    for i in range(forces.shape[1]):
        forces[0, i] = 0.0
    j = 0
    while j < table.shape[0]:
        _operate(functions, table, j, parameters, settings, kinematics, motions, forces, state, trace)
        j += 1


@compiled
def sample_loop(
    functions, the_table, the_parameters, the_settings, kinematics, motions, forces, the_state, the_solvers, trace
):
    """``run`` with a series: sample by sample; then effects of the measurement chain, which need the whole block."""
    rows = kinematics.shape[0]
    new_column, new_deflected, new_compliance = np.empty((rows, 1)), np.empty((rows, 1)), np.empty(1)
    new_inner, new_saved = np.empty((motions.shape[0], rows, 1)), np.empty_like(the_state)
    new_force, new_mark = np.zeros((forces.shape[0], 1)), np.zeros((trace.shape[0], 1))
    work = (new_column, new_inner, new_deflected, new_force, new_mark, new_saved, new_compliance)
    column, inner, deflected, force, mark, saved, compliance = borrowed(work)
    table, parameters, settings = borrowed(the_table), borrowed(the_parameters), borrowed(the_settings)
    state, solvers = borrowed(the_state), borrowed(the_solvers)
    for i in range(kinematics.shape[1]):
        for k in range(kinematics.shape[0]):
            column[k, 0] = kinematics[k, i]
        force[0, 0] = 0.0
        j = 0
        while j < table.shape[0]:
            if table[j, CODE] == SERIES:
                _begin_series(table, j, column, inner, force, state, saved, solvers[j])
            elif table[j, CODE] == SOLVE:
                j = _advance_series(
                    functions, table, j, parameters, settings, column, inner, force, state, saved, solvers, mark,
                    deflected, compliance,
                )  # fmt: skip
            elif table[j, CODE] != SCALE and table[j, CODE] != CHANNEL:
                _operate(functions, table, j, parameters, settings, column, inner, force, state, mark)
            j += 1
        forces[0, i] = force[0, 0]
        for k in range(trace.shape[0]):
            trace[k, i] = mark[k, 0]
    for j in range(table.shape[0]):
        if table[j, CODE] == CHANNEL:
            _run_kernel(functions, table, j, parameters, settings, kinematics, forces[0], state, trace)
    work[0][0, 0] = 0.0  # a use: the work space must live until here


_run_block, _run_samples = by_address(block_loop, BLOCK_LOOP), by_address(sample_loop, SAMPLE_LOOP)


@compiled
def run(functions, table, parameters, settings, kinematics, motions, forces, state, solvers, trace):
    """Runs the program on a block.

    Args:
        functions: from ``program.function_list``.
        table: (m, 13) int64, one operation per row.
        parameters, settings: flat float64 arrays.
        kinematics: (8, n); unchanged.
        motions: (k, 8, n) registers 1 to k, for paths that change the motion.
        forces: (l, n) registers; register 0 holds the result.
        state: flat float64 array, carried.
        solvers: (m, 6) work space of the series operations; (0, 6) without series.
        trace: (m, n) receives the change of the force by each operation; or (0, 0).
    """
    if solvers.shape[0] == 0:
        _run_block(functions, table, parameters, settings, kinematics, motions, forces, state, solvers, trace)
    else:
        _run_samples(functions, table, parameters, settings, kinematics, motions, forces, state, solvers, trace)


@compiled
def run_with_resets(
    functions, table, parameters, settings, kinematics, motions, forces, state, series, restart, trace, out
):
    """Runs the program on a block that can contain resets; a non-finite force also resets the state.

    Args:
        functions, table, parameters, settings, kinematics, state, trace: as in ``run``.
        motions, forces: numbers of registers of the program.
        series: whether the program has a series operation.
        restart: (1,), carried: 1 if the next sample is the first after a reset, else 0.
        out: (n,) N, the forces; not finite where the model has no finite force.
    """
    size = kinematics.shape[1]
    first, length = 0, size
    while first < size:
        last = first + 1
        while last < min(first + length, size) and kinematics[DT, last] > 0.0:
            last += 1
        piece = kinematics if last - first == size and restart[0] == 0 else kinematics[:, first:last].copy()
        if restart[0] != 0:
            piece[DT, 0] = 0.0
        if piece[DT, 0] <= 0.0:
            for k in range(state.size):
                state[k] = 0.0
        count = last - first
        registers = np.empty((forces, count))
        marks = trace if count == size else np.zeros((trace.shape[0], count))
        moved = np.empty((motions, kinematics.shape[0], count))
        solvers = np.empty((table.shape[0] if series else 0, SOLVER_COLUMNS))
        run(functions, table, parameters, settings, piece, moved, registers, state, solvers, marks)
        restart[0] = 0
        for i in range(count):
            out[first + i] = registers[0, i]
            for k in range(trace.shape[0]):
                trace[k, first + i] = marks[k, i]
            if not np.isfinite(registers[0, i]):
                # The rest was computed from a lost state: repeat it, in growing pieces.
                restart[0], last, length = 1, first + i + 1, 1
                break
        if restart[0] == 0:
            length = max(2 * length, 2)
        first = last


@inlined
def _operate(functions, table, j, parameters, settings, kinematics, motions, forces, state, trace):
    """One operation other than a series."""
    register = table[j, FORCE]
    if table[j, CODE] == ENTER:
        for i in range(forces.shape[1]):
            forces[register, i] = 0.0
        if table[j, MOTION] != table[j, MOTION_UP]:
            above = table[j, MOTION_UP]
            given = kinematics if above == 0 else motions[above - 1]
            for k in range(given.shape[0]):
                for i in range(given.shape[1]):
                    motions[table[j, MOTION] - 1, k, i] = given[k, i]
    elif table[j, CODE] == LEAVE:
        for i in range(forces.shape[1]):
            forces[table[j, FORCE_UP], i] += forces[register, i]
    else:
        level = table[j, MOTION]
        moving = kinematics if level == 0 else motions[level - 1]
        _run_kernel(functions, table, j, parameters, settings, moving, forces[register], state, trace)


@inlined
def _run_kernel(functions, table, j, parameters, settings, kinematics, force, state, trace):
    """The kernel of an operation on a force (n,), and what it changes."""
    if trace.shape[0] > 0:
        for i in range(force.size):
            trace[j, i] = -force[i]
    call_kernel(
        functions, table[j, KERNEL],
        part(parameters, table[j, P0], table[j, P1]), part(settings, table[j, S0], table[j, S1]),
        kinematics, part(state, table[j, Z0], table[j, Z1]), force,
    )  # fmt: skip
    if trace.shape[0] > 0:
        for i in range(force.size):
            trace[j, i] += force[i]


@inlined
def _begin_series(table, j, column, motions, force, state, saved, solver):
    """Saves the states before this sample and tries the deflection that the last two rates predict."""
    first, last = table[j, Z0], table[table[j, PARTNER], Z1]
    for k in range(first, last):
        saved[k] = state[k]
    above = table[j, MOTION_UP]
    given = column if above == 0 else motions[above - 1]
    solver[TRIAL] = state[first + DEFLECTION] + (2.0 * state[first + RATE] - state[first + BEFORE]) * given[DT, 0]
    solver[LOW], solver[HIGH] = -np.inf, np.inf
    solver[COUNT] = 0.0
    _try_deflection(table, j, given, motions, force, saved, solver)


@inlined
def _try_deflection(table, j, given, motions, force, saved, solver):
    """Sets the path's motion to the given one less the trial deflection, and its force to zero."""
    inner = motions[table[j, MOTION] - 1]
    for k in range(given.shape[0]):
        inner[k, 0] = given[k, 0]
    inner[X, 0] = given[X, 0] - solver[TRIAL]
    inner[V, 0] = given[V, 0] - rate_of(given[DT, 0], saved, table[j, Z0], solver[TRIAL])
    force[table[j, FORCE], 0] = 0.0


@inlined
def _advance_series(
    functions, table, end, parameters, settings, column, motions, force, state, saved, solvers, mark, deflected,
    compliance,
):  # fmt: skip
    """Compares compliance and path at the trial; returns ``end`` if they balance, else the row from which to run the
    path again."""
    begin = table[end, PARTNER]
    solver = solvers[begin]
    first, last = table[begin, Z0], table[end, Z1]
    above = table[begin, MOTION_UP]
    given = column if above == 0 else motions[above - 1]
    path_force = force[table[begin, FORCE], 0]
    for k in range(given.shape[0]):
        deflected[k, 0] = given[k, 0]
    deflected[X, 0] = solver[TRIAL]
    deflected[V, 0] = rate_of(given[DT, 0], saved, first, solver[TRIAL])
    deflected[STROKE, 0] = given[X, 0]
    compliance[0] = 0.0
    call_kernel(
        functions, table[begin, KERNEL],
        part(parameters, table[begin, P0], table[begin, P1]), part(settings, table[begin, S0], table[begin, S1]),
        deflected, part(state, first + SERIES_STATES, table[begin, Z1]), compliance,
    )  # fmt: skip
    j = begin + 2
    while table[j, CODE] == SCALE:
        call_kernel(
            functions, table[j, KERNEL],
            part(parameters, table[j, P0], table[j, P1]), part(settings, table[j, S0], table[j, S1]),
            given, part(state, table[j, Z0], table[j, Z1]), compliance,
        )  # fmt: skip
        j += 1
    slope = saved[first + SLOPE] if saved[first + SLOPE] > 0.0 else _START_SLOPE
    deflection, g = solver[TRIAL], compliance[0] - path_force
    if balanced(solver, g, _TOLERANCE * (100.0 + abs(path_force)), slope, saved[first + DEFLECTION]):
        state[first + DEFLECTION] = deflection
        state[first + BEFORE] = saved[first + RATE]
        state[first + RATE] = mean_rate(given[DT, 0], saved, first, deflection)
        state[first + STEP] = given[DT, 0]
        state[first + SLOPE] = secant_slope(solver, deflection, g, slope)
        force[table[begin, FORCE_UP], 0] += path_force
        if mark.shape[0] > 0:
            for k in range(begin, end + 1):
                mark[k, 0] = 0.0
            mark[begin, 0] = path_force
        return end
    for k in range(first, last):
        state[k] = saved[k]
    _try_deflection(table, begin, given, motions, force, saved, solver)
    return begin
