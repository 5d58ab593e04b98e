"""Several dampers that share one input: stamps and raw displacement in, estimates out.

The node passes one message at a time, ``replay`` many at once; both run the same compiled code over the same records,
so that their forces agree bit for bit. The programs, parameters and states of the dampers are concatenated in shared
arrays.
"""

import numpy as np

from damper_estimator.compiled import borrowed, compiled, inlined, wait_for
from damper_estimator.model import DamperModel, chain
from damper_estimator.model.element import walk
from damper_estimator.model.program import function_list
from damper_estimator.runtime.damper_record import SLOW, fresh_record
from damper_estimator.runtime.deployed import Deployed
from damper_estimator.runtime.estimates import FIELDS
from damper_estimator.runtime.line_arrays import ABSENT, LineInput, LineOutput
from damper_estimator.runtime.slow import hold, is_recent
from damper_estimator.runtime.status import velocity_noise, watch
from damper_estimator.signals.admission import DUPLICATE, judge
from damper_estimator.signals.butterworth import differentiate
from damper_estimator.signals.fusion import fuse
from damper_estimator.signals.layout import COMMAND, DT, ROWS, A, T, V, X
from damper_estimator.signals.possible import keep_possible

_DISPLACEMENT, _VELOCITY, _ACCELERATION, _FORCE, _STDDEV = (FIELDS.index(name) for name in FIELDS[:5])


class Line:
    """The running state of k dampers that share one input; dampers can be added while it runs; final.

    Attributes:
        names: of the dampers.
        records: (k,) of ``runtime.damper_record.RECORD``.
        scale, offset: (k,) of the displacement in a message: m = scale * raw + offset.
        input: of one message; slow channels and accelerations are stored here as they arrive, see `step`.
        doubted: (k,) bool, dampers whose samples are doubtful for a reason outside the line.
        output: of the last `step`.
    """

    def __init__(self) -> None:
        self.names: tuple[str, ...] = ()
        self.records = fresh_record()[:0]
        self.scale, self.offset, self.doubted = np.zeros(0), np.zeros(0), np.zeros(0, bool)
        self.input = LineInput.empty(1, 0)
        self.output = LineOutput.empty(1, 0)
        self._kernels: list = []
        self._functions, self._series = function_list([], False), False
        self._table = np.zeros((0, chain.COLUMNS), np.int64)
        self._parameters, self._constants, self._states = np.zeros(0), np.zeros(0), np.zeros(0)
        self._live: tuple = ()  # arguments of `_step`; assembled once, since that costs as much as a damper

    def add(self, name: str, damper: Deployed, scale: float = 1.0, offset: float = 0.0) -> None:
        """Adds a damper, with the scaling of its displacement in the messages; the others' states stay."""
        self._append_program(damper.model)
        program, rows, states = damper.model.program, self._table.shape[0], self._states.size
        record = damper.record()
        wait_for(watch, _step)
        record["first_row"], record["last_row"] = rows - program.table.shape[0], rows
        # The last number says whether the model restarts at the next sample.
        record["first_state"], record["last_state"] = states - program.states - 1, states - 1
        record["motions"], record["forces"], record["series"] = program.motions, program.forces, program.series
        self.names = (*self.names, name)
        self.records = np.concatenate([self.records, record])
        self.scale, self.offset = np.append(self.scale, scale), np.append(self.offset, offset)
        self.doubted = np.append(self.doubted, False)
        self.input = self.input.with_another_damper()
        self.output = self.output.with_another_damper()
        self._live = (self.scale, self.offset, self.doubted, *self._arguments(self.input, self.output))

    def _append_program(self, model: DamperModel) -> None:
        program = model.program
        table = program.table.copy()
        table[:, chain.KERNEL] += len(self._kernels)
        for first, size in ((chain.P0, self._parameters.size), (chain.S0, self._constants.size)):
            table[:, first : first + 2] += size
        # In the order of the program.
        self._kernels += [e.effect.kernel for e in walk(model.effects) if e.effect.kernel is not None]
        self._series = self._series or program.series
        self._functions = function_list(self._kernels, self._series)
        self._table = np.concatenate([self._table, table])
        self._parameters = np.concatenate([self._parameters, program.parameters])
        self._constants = np.concatenate([self._constants, program.settings])
        self._states = np.concatenate([self._states, np.zeros(program.states + 1)])

    def step(self, stamp: int, raw: np.ndarray, present: np.ndarray, suspect: bool = False) -> int:
        """Runs the samples of one message, with the slow channels in ``input``; fills ``output``.

        Args:
            stamp: ns.
            raw: (k,) displacements in the message.
            present: (k,) bool, whether it contains the damper.
            suspect: whether it is doubtful for all dampers, not only for the ``doubted`` ones.

        Returns:
            The number of estimates.
        """
        return _step(stamp, raw, present, suspect, *self._live) if self._live else 0

    def run(self, messages: LineInput) -> LineOutput:
        """Runs n messages; the same, bit for bit, as n times `step`."""
        output = LineOutput.empty(messages.stamp.size, len(self.names))
        if self.names:
            _run_messages(*self._arguments(messages, output))
        return output

    def _arguments(self, messages: LineInput, output: LineOutput) -> tuple:
        return (
            self._functions, self._table, self._parameters, self._constants, self._states, self.records,
            *messages.arrays(), *output.arrays(),
        )  # fmt: skip

    def is_good(self, damper: int | slice) -> np.ndarray:
        """Whether the last `step` used a sample of the damper of this number."""
        verdict = self.output.verdict[0, damper]
        return (verdict < DUPLICATE) & (verdict > ABSENT)

    def sample(self, damper: int) -> np.ndarray:
        """The last sample of the damper of this number, (8,) in the rows of ``signals.layout``; a view."""
        return self.output.blocks[damper, :, 0]

    def velocity_noise(self, damper: int) -> float:
        """Standard deviation in m/s of the velocity, from the noise of the displacement, of the damper of this number;
        0 if it is unknown.
        """
        return _velocity_noise(self.records, damper)


@compiled
def _velocity_noise(records, damper):
    return velocity_noise(records[damper])


@compiled
def _step(
    now, raw, held, in_doubt, scale, offset, doubted, functions, table, parameters, constants, states, records, stamp,
    displacement, present, suspect, slow, received, acceleration, acceleration_stamp, verdicts, status, trusted,
    modelled, numbers, blocks,
):  # fmt: skip
    """See ``Line.step``: fills the input of ``_run`` from a message; in one call, since a call costs as much as a
    damper.
    """
    stamp[0] = now
    for d in range(raw.size):
        displacement[0, d] = scale[d] * raw[d] + offset[d]
        present[0, d], suspect[0, d] = held[d], in_doubt or doubted[d]
    return _run(
        functions, table, parameters, constants, states, records, stamp, displacement, present, suspect, slow, received,
        acceleration, acceleration_stamp, verdicts, status, trusted, modelled, numbers, blocks,
    )  # fmt: skip


@compiled
def _run_messages(
    functions, table, parameters, constants, states, records, stamp, displacement, present, suspect, slow, received,
    acceleration, acceleration_stamp, verdicts, status, trusted, modelled, numbers, blocks,
):  # fmt: skip
    """See ``Line.run``."""
    return _run(
        functions, table, parameters, constants, states, records, stamp, displacement, present, suspect, slow, received,
        acceleration, acceleration_stamp, verdicts, status, trusted, modelled, numbers, blocks,
    )  # fmt: skip


@inlined
def _run(
    functions, table, parameters, constants, states, records, stamp, displacement, present, suspect, slow, received,
    acceleration, acceleration_stamp, verdicts, status, trusted, modelled, numbers, blocks,
):  # fmt: skip
    """Runs n messages; arrays as in ``Line``, `LineInput` and `LineOutput`."""
    n, estimates = stamp.size, 0
    program = (table, parameters, constants, states)
    inputs = (stamp, displacement, present, suspect, slow, received, acceleration, acceleration_stamp)
    outputs = (verdicts, status, trusted, modelled, numbers, blocks)
    work = (np.empty((3, n), np.int64), np.empty((5, n)), np.empty((2, n), np.uint8), np.empty(n, np.int64))
    # A message nearly always contains a used sample: memory for it is allocated once for all dampers.
    usual = (np.empty((ROWS, n)), np.empty((2, n), np.uint8))
    for d in range(records.shape[0]):
        estimates += _run_damper(d, records[d], functions, program, inputs, outputs, work, usual)
    return estimates


@compiled
def _run_damper(d, record, functions, program, inputs, outputs, work, usual):
    """The same for the damper of number d; returns its number of estimates. ``_run`` keeps the arrays alive."""
    table, parameters, constants, states = borrowed(program)
    stamp, displacement, present, suspect, slow, received, acceleration, acceleration_stamp = borrowed(inputs)
    verdicts, status, trusted, modelled, numbers, blocks = borrowed(outputs)
    whole, real, flags, all_doubt = borrowed(work)
    usual_block, usual_judged = borrowed(usual)
    place, times, verdict = whole[0], whole[1], whole[2]
    value, dt, doubtful = real[0], real[1], flags[0]
    n, arrivals, good = stamp.size, 0, 0
    for i in range(n):
        if present[i, d]:
            place[arrivals], times[arrivals] = i, stamp[i]
            value[arrivals], doubtful[arrivals] = displacement[i, d], suspect[i, d]
            arrivals += 1
        else:
            verdicts[i, d] = ABSENT
    judge(times[:arrivals], value[:arrivals], record["max_gap"], record["admission"], verdict[:arrivals], dt[:arrivals])
    used = real[2]
    keep_possible(value[:arrivals], verdict[:arrivals], dt[:arrivals], record["possible"], used[:arrivals])
    for j in range(arrivals):
        verdicts[place[j], d] = verdict[j]
        if verdict[j] < DUPLICATE:  # the good ones move up, so that filter and model process them without holes
            place[good], dt[good], used[good] = place[j], dt[j], used[j]
            good += 1
    raw, force, finite, alone, doubt = used[:good], real[3, :good], real[4, :good], flags[1, :good], all_doubt[:good]
    block = usual_block if good == n else np.empty((ROWS, good))
    judged = usual_judged if good == n else np.empty((2, good), np.uint8)
    for j in range(good):  # slices would take seconds to compile
        for row in range(ROWS):
            block[row, j] = np.nan
        alone[j], doubt[j] = 0, 0
    take_motion(record, d, place, stamp, dt[:good], raw, acceleration, acceleration_stamp, block, alone)
    take_slow(record, d, place, stamp, slow, received, block, doubt)
    if record["lead"] > 0.0:
        predict(record["lead"], block)
    chain.run_with_resets(
        functions, table[record["first_row"] : record["last_row"]], parameters, constants, block, record["motions"],
        record["forces"], states[record["first_state"] : record["last_state"]], record["series"],
        states[record["last_state"] : record["last_state"] + 1],
        np.empty((0, 0)), force,
    )  # fmt: skip
    watch(
        record, times[:arrivals], value[:arrivals], raw, verdict[:arrivals], doubtful[:arrivals], alone, doubt, block,
        force, judged[0], judged[1], finite,
    )  # fmt: skip
    for j in range(good):
        i = place[j]
        status[i, d], trusted[i, d], modelled[i, d] = judged[0, j], judged[1, j], force[j]
        numbers[i, _DISPLACEMENT, d], numbers[i, _VELOCITY, d] = block[X, j], block[V, j]
        numbers[i, _ACCELERATION, d] = block[A, j]
        numbers[i, _FORCE, d], numbers[i, _STDDEV, d] = finite[j], record["stddev"]
        for row in range(ROWS):
            blocks[d, row, i] = block[row, j]
    return good


@compiled
def take_motion(record, d, place, stamp, dt, raw, acceleration, acceleration_stamp, block, alone):
    """Time and motion of the good samples of one damper."""
    good = raw.size
    if good > 0 and record["begun"] == 0:
        record["begun"], record["origin"] = 1, stamp[place[0]]
    for j in range(good):
        block[T, j], block[DT, j] = (stamp[place[j]] - record["origin"]) / 1e9, dt[j]
    differentiate(record["cutoff"], dt, raw, record["filter"], block[X], block[V], block[A])
    if record["fuses"] == 0:
        return
    recent = np.empty(good)
    for j in range(good):
        i = place[j]
        recent[j] = acceleration[i, d] if is_recent(record, stamp[i], acceleration_stamp[i, d]) else np.nan
    fuse(record["noises"], dt, raw, recent, record["fused"], block[X], block[V], block[A], alone)


@compiled
def take_slow(record, d, place, stamp, slow, received, block, doubt):
    """The model's slow channels, and the time in ns for which each sample makes the force doubtful."""
    for j in range(doubt.size):
        i = place[j]
        for row in range(len(SLOW)):
            in_doubt = hold(record, stamp[i], row, slow[i, row, d], received[i, row, d])
            if in_doubt and record["matters"][row] != 0:
                doubt[j] = max(doubt[j], record["memory"][row], record["settling"])
            block[COMMAND + row, j] = record["held"][row]


@compiled
def predict(lead, block):
    """Moves displacement and velocity of a block (8, n) ``lead`` s ahead, with the acceleration held."""
    for i in range(block.shape[1]):
        block[X, i] += lead * (block[V, i] + 0.5 * lead * block[A, i])
        block[V, i] += lead * block[A, i]
