"""The generated C's processing of one sample, in the restricted Python that is translated with all functions that it
calls.

``step`` is ``runtime.line`` for one damper and one message; ``reach`` and ``invert`` are ``control.InverseModel``. All
numbers of a damper are in one record, ``state_type``; it is the only memory.
"""

import numpy as np

from damper_estimator.control import command_search as search
from damper_estimator.model import chain
from damper_estimator.runtime.damper_record import RECORD, SLOW, STALE
from damper_estimator.runtime.line import predict, take_motion, take_slow
from damper_estimator.runtime.status import watch
from damper_estimator.signals.admission import DUPLICATE, judge
from damper_estimator.signals.layout import COMMAND, DT, ROWS, A, V, X
from damper_estimator.signals.possible import keep_possible

_PROGRAM = ("first_row", "last_row", "first_state", "last_state", "motions", "forces", "series")

INPUT = np.dtype(
    [
        ("stamp", "i8"),
        ("displacement", "f8"),
        ("command", "f8"),
        ("temperature", "f8"),
        ("pressure", "f8"),
        ("acceleration", "f8"),
        ("acceleration_stamp", "i8"),
        ("command_arrived", "u1"),
        ("temperature_arrived", "u1"),
        ("pressure_arrived", "u1"),
        ("acceleration_arrived", "u1"),
        ("suspect", "u1"),
        ("reach", "u1"),
    ],
    align=True,
)
OUTPUT = np.dtype(
    [
        ("displacement", "f8"),
        ("velocity", "f8"),
        ("acceleration", "f8"),
        ("force", "f8"),
        ("force_stddev", "f8"),
        ("force_min", "f8"),
        ("force_max", "f8"),
        ("dforce_dvelocity", "f8"),
        ("dforce_dcurrent", "f8"),
        ("status", "u1"),
        ("trusted", "u1"),
        ("verdict", "u1"),
    ],
    align=True,
)
ANSWER = np.dtype(
    [("current", "f8"), ("expected", "f8"), ("force_min", "f8"), ("force_max", "f8"), ("dforce_dcurrent", "f8"),
     ("evaluations", "i4"), ("reached", "u1")],
    align=True,
)  # fmt: skip


def state_type(motions: int, forces: int, states: int, solvers: int, inverts: bool) -> np.dtype:
    """The record of a damper; arguments as in ``model.program.Program``, ``solvers`` rows of work space for series."""
    kept = [(name, RECORD[name]) for name in RECORD.names if name not in _PROGRAM]
    machine = [
        ("slow", "f8", (len(SLOW),)), ("arrived", "i8", (len(SLOW),)), ("felt", "f8"), ("felt_at", "i8"),
        ("stale_after", "i8"), ("status", "u1"), ("trusted", "u1"), ("begun_once", "u1"),
        ("restart", "u1"),
        ("block", "f8", (ROWS, 1)), ("chain", "f8", (states,)),
        ("motion", "f8", (motions, ROWS, 1)), ("sums", "f8", (forces, 1)),
        ("solvers", "f8", (solvers, chain.SOLVER_COLUMNS)),
    ]  # fmt: skip
    inverse = [
        ("sample", "f8", (ROWS, 1)), ("ahead", "f8", (ROWS, 1)),
        ("followed", "f8", (states,)), ("trial", "f8", (states,)),
        ("limits", "f8", (2,)), ("times", "f8", (2,)), ("remembered", "f8", (search.MEMORY,)),
        ("found", "f8", (search.RESULTS,)), ("is_new", "u1"), ("inverse_restart", "u1"),
    ]  # fmt: skip
    return np.dtype([*kept, *machine, *(inverse if inverts else [])], align=True)


def step(kernels, table, parameters, settings, state, given, answer):
    """Processes one sample; returns its verdict. The answer is set if the sample was used: below DUPLICATE."""
    _take_channels(state, given)
    stamp, verdict, doubt, place = (
        np.empty(1, np.int64),
        np.empty(1, np.int64),
        np.zeros(1, np.int64),
        np.zeros(1, np.int64),
    )
    value, used, dt, force, numbers = np.empty(1), np.zeros(1), np.zeros(1), np.zeros(1), np.empty(1)
    suspect, alone = np.empty(1, np.uint8), np.zeros(1, np.uint8)
    status, trusted = np.zeros(1, np.uint8), np.zeros(1, np.uint8)
    block = state["block"]
    block[:, :] = np.nan
    stamp[0], value[0], suspect[0] = given["stamp"], given["displacement"], given["suspect"]
    judge(stamp, value, state["max_gap"], state["admission"], verdict, dt)
    keep_possible(value, verdict, dt, state["possible"], used)
    if verdict[0] < DUPLICATE:
        _take_sample(kernels, table, parameters, settings, state, place, stamp, dt, used, block, alone, doubt, force)
    watch(state, stamp, value, used, verdict, suspect, alone, doubt, block, force, status, trusted, numbers)
    answer["verdict"] = verdict[0]
    if verdict[0] < DUPLICATE:
        answer["displacement"], answer["velocity"], answer["acceleration"] = block[X, 0], block[V, 0], block[A, 0]
        answer["force"], answer["force_stddev"] = numbers[0], state["stddev"]
        answer["status"], answer["trusted"] = status[0], trusted[0]
        state["status"], state["trusted"], state["begun_once"] = status[0], trusted[0], 1
        answer["force_min"] = answer["force_max"] = answer["dforce_dvelocity"] = answer["dforce_dcurrent"] = np.nan
    return verdict[0]


def step_and_follow(kernels, table, parameters, settings, state, given, answer):
    """The same for a damper with a command: updates the inverse and, on request, computes the reachable forces."""
    verdict = step(kernels, table, parameters, settings, state, given, answer)
    if verdict < DUPLICATE:
        _follow(kernels, table, parameters, settings, state)
        if given["reach"] != 0:
            found = state["found"]
            _solve(kernels, table, parameters, settings, state, np.nan, True)
            answer["force_min"], answer["force_max"] = found[search.LOWEST], found[search.HIGHEST]
            answer["dforce_dvelocity"], answer["dforce_dcurrent"] = (
                found[search.SLOPE_VELOCITY], found[search.SLOPE_CURRENT],
            )  # fmt: skip
    return verdict


def _take_channels(state, given):
    """Stores new values of slow channels and accelerometer."""
    if given["command_arrived"] != 0:
        state["slow"][0] = given["command"]
        state["arrived"][0] += 1
    if given["temperature_arrived"] != 0:
        state["slow"][1] = given["temperature"]
        state["arrived"][1] += 1
    if given["pressure_arrived"] != 0:
        state["slow"][2] = given["pressure"]
        state["arrived"][2] += 1
    if given["acceleration_arrived"] != 0:
        state["felt"], state["felt_at"] = given["acceleration"], given["acceleration_stamp"]


def _take_sample(kernels, table, parameters, settings, state, place, stamp, dt, value, block, alone, doubt, force):
    """Motion, slow channels and force of a sample that is used."""
    slow, heard = np.empty((1, len(SLOW), 1)), np.empty((1, len(SLOW), 1), np.int64)
    felt, felt_at = np.empty((1, 1)), np.empty((1, 1), np.int64)
    for row in range(len(SLOW)):
        slow[0, row, 0], heard[0, row, 0] = state["slow"][row], state["arrived"][row]
    felt[0, 0], felt_at[0, 0] = state["felt"], state["felt_at"]
    take_motion(state, 0, place, stamp, dt, value, felt, felt_at, block, alone)
    take_slow(state, 0, place, stamp, slow, heard, block, doubt)
    if state["lead"] > 0.0:
        predict(state["lead"], block)
    step_before = block[DT, 0]
    if state["restart"] != 0:
        block[DT, 0] = 0.0
    if block[DT, 0] <= 0.0:
        state["chain"][:] = 0.0
    trace = np.zeros((0, 0))
    chain.run(
        kernels,
        table,
        parameters,
        settings,
        block,
        state["motion"],
        state["sums"],
        state["chain"],
        state["solvers"],
        trace,
    )
    force[0] = state["sums"][0, 0]
    state["restart"] = 0 if np.isfinite(force[0]) else 1
    block[DT, 0] = step_before


def status_at(state, now):
    """Status of the last estimate at a time in ns of the stamps' clock: STALE if older than ``stale_after``."""
    if state["begun_once"] == 0 or now - state["last"] > state["stale_after"]:
        return STALE
    return int(state["status"])


def _follow(kernels, table, parameters, settings, state):
    """Stores a sample for the inverse; a sample without a request advances the inverse's copy of the model."""
    trace = np.zeros((0, 0))
    if state["is_new"] != 0:
        machine = (kernels, table, parameters, settings, state["motion"], state["sums"], state["solvers"], trace)
        force = search.advance(machine, state["sample"], state["followed"])
        state["inverse_restart"] = 0 if np.isfinite(force) else 1
    sample = state["sample"]
    sample[:, :] = state["block"]
    if np.isnan(sample[COMMAND, 0]):
        sample[COMMAND, 0] = state["remembered"][search.LAST]
    if state["inverse_restart"] != 0:
        sample[DT, 0] = 0.0
    state["is_new"] = 1


def _solve(kernels, table, parameters, settings, state, wanted, with_slope):
    """``InverseModel.solve`` at the last sample, or ``again`` after an earlier request."""
    trace = np.zeros((0, 0))
    search.invert(
        kernels, table, parameters, settings, state["motion"], state["sums"], state["solvers"], trace, state["sample"],
        state["is_new"] != 0, state["ahead"], state["followed"], state["trial"], state["limits"], state["times"],
        wanted, with_slope, state["remembered"], state["found"],
    )  # fmt: skip
    state["is_new"] = 0
    state["inverse_restart"] = 0 if np.isfinite(state["found"][search.FORCE]) else 1


def inverse(kernels, table, parameters, settings, state, wanted, answer):
    """The command for a desired force (N) after the last sample; NaN before the first sample."""
    found = state["found"]
    if state["begun_once"] == 0:
        found[:] = np.nan
        found[search.EVALUATIONS] = found[search.REACHED] = 0.0
    else:
        _solve(kernels, table, parameters, settings, state, wanted, False)
    answer["current"], answer["expected"] = found[search.CURRENT], found[search.EXPECTED]
    answer["force_min"], answer["force_max"] = found[search.LOWEST], found[search.HIGHEST]
    answer["dforce_dcurrent"] = found[search.SLOPE_CURRENT]
    answer["evaluations"] = int(found[search.EVALUATIONS])
    answer["reached"] = 1 if found[search.REACHED] > 0.0 else 0
