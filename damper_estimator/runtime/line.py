"""Several dampers that share one input: stamps and raw displacement in, estimates out.

The node gives it one message at a time, ``replay`` many at once; both run the same compiled code over the same records,
so that their forces agree bit for bit. The programs, parameters and states of the dampers lie one behind the other in
shared arrays.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.model import DamperModel, chain
from damper_estimator.model.element import walk
from damper_estimator.runtime.deployed import Deployed
from damper_estimator.runtime.estimates import FIELDS
from damper_estimator.runtime.messages import ABSENT, Answered, Arrived
from damper_estimator.runtime.record import SLOW, fresh_record
from damper_estimator.runtime.slow import hold
from damper_estimator.runtime.status import SETTLED, velocity_noise, watch
from damper_estimator.signals.admission import DUPLICATE, judge
from damper_estimator.signals.butterworth import differentiate
from damper_estimator.signals.fusion import fuse
from damper_estimator.signals.layout import COMMAND, DT, ROWS, A, T, V, X

_DISPLACEMENT, _VELOCITY, _ACCELERATION, _FORCE, _STDDEV = (FIELDS.index(name) for name in FIELDS[:5])


class Line:
    """The running state of k dampers that share one input; dampers can be added while it runs; final.

    Attributes:
        names: of the dampers.
        records: (k,) of ``runtime.record.RECORD``.
        arrived: of one message, where slow channels and accelerations are put as they come; see `step`.
        answered: what the last `step` brought about.
    """

    def __init__(self) -> None:
        self.names: tuple[str, ...] = ()
        self.records = fresh_record()[:0]
        self.arrived = Arrived.nothing(1, 0)
        self.answered = Answered.room_for(1, 0)
        self._functions: list = []
        self._kernels: list = []
        self._table = np.zeros((0, chain.COLUMNS), np.int64)
        self._parameters, self._constants, self._states = np.zeros(0), np.zeros(0), np.zeros(0)

    def add(self, name: str, own: Deployed) -> None:
        """Takes one more damper; the others' states stay."""
        self._append_program(own.model)
        program, rows, states = own.model.program, self._table.shape[0], self._states.size
        record = own.record()
        record["first_row"], record["last_row"] = rows - program.table.shape[0], rows
        record["first_state"], record["last_state"] = states - program.states, states
        record["motions"], record["forces"], record["series"] = program.motions, program.forces, program.series
        self.names = (*self.names, name)
        self.records = np.concatenate([self.records, record])
        self.arrived = self.arrived.with_one_more()
        self.answered = self.answered.with_one_more()

    def _append_program(self, model: DamperModel) -> None:
        program = model.program
        table = program.table.copy()
        table[:, chain.KERNEL] += len(self._functions)
        for first, size in ((chain.P0, self._parameters.size), (chain.S0, self._constants.size)):
            table[:, first : first + 2] += size
        # In the order in which the program counts them.
        self._functions += [e.effect.kernel for e in walk(model.effects) if e.effect.kernel is not None]
        self._kernels = chain.kernel_list(self._functions)
        self._table = np.concatenate([self._table, table])
        self._parameters = np.concatenate([self._parameters, program.parameters])
        self._constants = np.concatenate([self._constants, program.settings])
        self._states = np.concatenate([self._states, np.zeros(program.states)])

    def step(self, stamp: int, displacement: np.ndarray, present: np.ndarray, suspect: bool = False) -> int:
        """Runs the samples of one message, with the slow channels as ``arrived`` has them; fills ``answered``.

        Args:
            stamp: ns.
            displacement: (k,) m.
            present: (k,) bool, whether the message held the damper.
            suspect: whether its sender is in doubt.

        Returns:
            How many estimates there are.
        """
        arrived = self.arrived
        arrived.stamp[0], arrived.suspect[0] = stamp, suspect
        arrived.displacement[0], arrived.present[0] = displacement, present
        return self._run(arrived, self.answered)

    def run(self, arrived: Arrived) -> Answered:
        """Runs n messages; the same, bit for bit, as n times `step`."""
        answered = Answered.room_for(arrived.stamp.size, len(self.names))
        self._run(arrived, answered)
        return answered

    def _run(self, arrived: Arrived, answered: Answered) -> int:
        return _run(
            self._kernels, self._table, self._parameters, self._constants, self._states, self.records,
            *arrived.parts(), *answered.parts(),
        )  # fmt: skip

    def is_good(self, damper: int | slice) -> np.ndarray:
        """Whether the last `step` brought a sample of the damper of this number that was used."""
        verdict = self.answered.verdict[0, damper]
        return (verdict < DUPLICATE) & (verdict > ABSENT)

    def sample(self, damper: int) -> np.ndarray:
        """The last sample of the damper of this number, (8,) in the rows of ``signals.layout``; a view."""
        return self.answered.blocks[damper, :, 0]

    def velocity_noise(self, damper: int) -> float:
        """Standard deviation in m/s of the velocity, from the noise of the displacement, of the damper of this number;
        0 where it cannot be told."""
        return _velocity_noise(self.records, damper)


@compiled
def _velocity_noise(records, damper):
    return velocity_noise(records[damper])


@compiled
def _run(
    kernels, table, parameters, constants, states, records, stamp, displacement, present, suspect, slow, heard, felt,
    felt_at, verdicts, status, trusted, modelled, numbers, blocks,
):  # fmt: skip
    """See ``Line.run``; arrays as in ``Line``, `Arrived` and `Answered`."""
    n, estimates = stamp.size, 0
    place, own_stamp, value, dt = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n), np.empty(n)
    verdict, doubtful = np.empty(n, np.int64), np.empty(n, np.uint8)
    for d in range(records.shape[0]):
        own, came, good = records[d], 0, 0
        for i in range(n):
            if present[i, d]:
                place[came], own_stamp[came], value[came], doubtful[came] = i, stamp[i], displacement[i, d], suspect[i]
                came += 1
            else:
                verdicts[i, d] = ABSENT
        judge(own_stamp[:came], value[:came], own["max_gap"], own["admission"], verdict[:came], dt[:came])
        for j in range(came):
            verdicts[place[j], d] = verdict[j]
            if verdict[j] < DUPLICATE:  # the good ones move up, so that filter and model see them without holes
                place[good], dt[good] = place[j], dt[j]
                good += 1
        block, raw = np.full((ROWS, good), np.nan), np.empty(good)
        motion_alone, doubt = np.zeros(good, np.uint8), np.zeros(good, np.int64)
        for j in range(good):
            raw[j] = displacement[place[j], d]
        take_motion(own, d, place, stamp, dt[:good], raw, felt, felt_at, block, motion_alone)
        take_slow(own, d, place, stamp, slow, heard, block, doubt)
        if own["lead"] > 0.0:
            predict(own["lead"], block)
        force, numbers_given = np.empty(good), np.empty(good)
        chain.run_with_resets(
            kernels, table[own["first_row"] : own["last_row"]], parameters, constants, block, own["motions"],
            own["forces"], states[own["first_state"] : own["last_state"]], own["series"], own["restart"],
            np.empty((0, 0)), force,
        )  # fmt: skip
        judged = np.empty((2, good), np.uint8)
        watch(
            own, own_stamp[:came], value[:came], verdict[:came], doubtful[:came], motion_alone, doubt, block, force,
            judged[0], judged[1], numbers_given,
        )  # fmt: skip
        for j in range(good):
            i = place[j]
            status[i, d], trusted[i, d], modelled[i, d] = judged[0, j], judged[1, j], force[j]
            numbers[i, _DISPLACEMENT, d], numbers[i, _VELOCITY, d] = block[X, j], block[V, j]
            numbers[i, _ACCELERATION, d] = block[A, j]
            numbers[i, _FORCE, d], numbers[i, _STDDEV, d] = numbers_given[j], own["stddev"]
            blocks[d, :, i] = block[:, j]
        estimates += good
    return estimates


@compiled
def take_motion(own, d, place, stamp, dt, raw, felt, felt_at, block, alone):
    """Time and motion of the good samples of one damper."""
    good = raw.size
    if good > 0 and own["begun"] == 0:
        own["begun"], own["origin"] = 1, stamp[place[0]]
    for j in range(good):
        block[T, j], block[DT, j] = (stamp[place[j]] - own["origin"]) / 1e9, dt[j]
    differentiate(own["cutoff"], dt, raw, own["filter"], block[X], block[V], block[A])
    if own["fuses"] == 0:
        return
    recent = np.empty(good)
    for j in range(good):
        i = place[j]
        recent[j] = felt[i, d] if abs(stamp[i] - felt_at[i, d]) <= own["max_gap"] else np.nan
    fuse(own["noises"], dt, raw, recent, own["fused"], block[X], block[V], block[A], alone)


@compiled
def take_slow(own, d, place, stamp, slow, heard, block, doubt):
    """What the model sees of the slow channels, and for how long (ns) each sample leaves them in doubt."""
    for j in range(doubt.size):
        i = place[j]
        for row in range(len(SLOW)):
            in_doubt = hold(own, stamp[i], row, slow[i, row, d], heard[i, row, d])
            if in_doubt and own["matters"][row] != 0:
                doubt[j] = max(doubt[j], own["memory"][row], SETTLED)
            block[COMMAND + row, j] = own["held"][row]


@compiled
def predict(lead, block):
    """Moves displacement and velocity of a block (8, n) ``lead`` s ahead, with the acceleration held."""
    for i in range(block.shape[1]):
        block[X, i] += lead * (block[V, i] + 0.5 * lead * block[A, i])
        block[V, i] += lead * block[A, i]
