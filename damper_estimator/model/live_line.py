"""Several dampers one sample at a time, in one compiled call: what the node runs at the rate of its input.

The kernels are those of the blocks (admission, filter, chain, status), so that live and replayed forces agree bit for
bit. The programs, parameters and states of the dampers lie one behind the other in shared arrays.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.model import chain
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.model.element import walk
from damper_estimator.model.estimator import FIELDS, Deployed, predict
from damper_estimator.model.status import COUNTS, LEVELS, MARKS, watch
from damper_estimator.signals.admission import DUPLICATE, judge
from damper_estimator.signals.butterworth import STATE_SIZE, differentiate
from damper_estimator.signals.fusion import FUSION_SIZE, NOISES, fuse
from damper_estimator.signals.layout import COMMAND, DT, ROWS, A, T, V, X

SLOW = ("command", "temperature", "pressure")  # the rows from COMMAND on
ABSENT = -1  # verdict on a damper that was not in the message
_DISPLACEMENT, _VELOCITY, _ACCELERATION, _FORCE, _STDDEV = (FIELDS.index(name) for name in FIELDS[:5])
# Columns of a damper's row of integers: operations, states, registers, whether it has series effects; then the running
# ones: whether it had a sample, the first stamp, whether the model starts anew.
R0, R1, Z0, Z1, MOTIONS, FORCES, SERIES, BEGUN, ORIGIN, RESTART = range(10)
_PLACES = 10
# Columns of its row of settings.
CUTOFF, LEAD, STDDEV, NOISE_CUTOFF, NOISE = range(5)  # from NOISE on those of the fusion; 0 where there is none
_SETTINGS = NOISE + NOISES


class LiveLine:
    """The running state of k dampers that share one input; dampers can be added while it runs; final.

    Attributes:
        names: of the dampers.
        verdicts: (k,) int64, what became of the last sample (``signals.admission``), or ABSENT.
        estimates: (9, k) numbers of damper_msgs/DamperForces by `FIELDS`; valid where the verdict is below DUPLICATE.
        status: (k,) uint8, the same.
        modelled: (k,) N, the model's force, the same; not finite where it gave none.
        held: (3, k) values of the slow channels, NaN before the first.
        felt, felt_at: (k,) m/s^2 and int64 ns, held values and stamps of the accelerometers.
        counts: (k, COUNTS) as in ``model.status``; they only grow.
        levels: (k, LEVELS), the same.
    """

    def __init__(self) -> None:
        self.names: tuple[str, ...] = ()
        self.verdicts = np.zeros(0, np.int64)
        self.status = np.zeros(0, np.uint8)
        self.modelled = np.zeros(0)
        self.estimates = np.zeros((len(FIELDS), 0))
        self.held = np.zeros((len(SLOW), 0))
        self.felt, self.felt_at = np.zeros(0), np.zeros(0, np.int64)
        self.counts = np.zeros((0, COUNTS), np.int64)
        self.levels = np.zeros((0, LEVELS))
        self._marks = np.zeros((0, MARKS), np.int64)
        self._places = np.zeros((0, _PLACES), np.int64)
        self._settings = np.zeros((0, _SETTINGS))
        self._max_gap = np.zeros(0, np.int64)
        self._bounds = np.zeros((0, ROWS, 2))
        self._admission = np.zeros((0, 2), np.int64)
        self._filters = np.zeros((0, STATE_SIZE))
        self._fusions = np.zeros((0, FUSION_SIZE))
        self._blocks = np.zeros((0, ROWS, 1))
        self._functions: list = []
        self._kernels: list = []
        self._table = np.zeros((0, chain.COLUMNS), np.int64)
        self._parameters, self._constants, self._states = np.zeros(0), np.zeros(0), np.zeros(0)
        self._motions, self._forces = np.zeros((0, ROWS, 1)), np.zeros((1, 1))
        self._solvers = np.zeros((0, chain.SOLVER_COLUMNS))
        self._stamp, self._value, self._dt = np.zeros(1, np.int64), np.zeros(1), np.zeros(1)
        self._felt, self._alone = np.zeros(1), np.zeros(1, np.uint8)

    def add(self, name: str, own: Deployed) -> None:
        """Takes one more damper; the others' states stay."""
        program = own.model.program
        self._append_program(own.model)
        rows, states = self._table.shape[0], self._states.size
        place = np.zeros((1, _PLACES), np.int64)
        place[0, :SERIES + 1] = (
            rows - program.table.shape[0], rows, states - program.states, states,
            program.motions, program.forces, program.series,
        )  # fmt: skip
        self.names = (*self.names, name)
        self._places = np.concatenate([self._places, place])
        noises = np.zeros(NOISES) if own.fusion is None else own.fusion.noises()
        settings = [own.cutoff, own.lead, own.stddev, own.noise_cutoff, *noises]
        self._settings = np.concatenate([self._settings, [settings]])
        self.felt = np.append(self.felt, np.nan)
        self._max_gap = np.append(self._max_gap, round(own.max_gap * 1e9))
        self._bounds = np.concatenate([self._bounds, own.bounds[None]])
        self.held = np.column_stack([self.held, np.full(len(SLOW), np.nan)])
        self.estimates = np.column_stack([self.estimates, np.full(len(FIELDS), np.nan)])
        for attribute in (
            "verdicts",
            "status",
            "modelled",
            "counts",
            "levels",
            "_marks",
            "_admission",
            "_filters",
            "_fusions",
            "felt_at",
            "_blocks",
        ):
            before = getattr(self, attribute)
            setattr(self, attribute, np.concatenate([before, np.zeros((1, *before.shape[1:]), before.dtype)]))

    def _append_program(self, model: DamperModel) -> None:
        program = model.program
        table = program.table.copy()
        table[:, chain.KERNEL] += len(self._functions)
        for first, size in (
            (chain.P0, self._parameters.size),
            (chain.S0, self._constants.size),
            (chain.Z0, self._states.size),
        ):
            table[:, first : first + 2] += size
        # In the order in which the program counts them.
        self._functions += [e.effect.kernel for e in walk(model.effects) if e.effect.kernel is not None]
        self._kernels = chain.kernel_list(self._functions)
        self._table = np.concatenate([self._table, table])
        self._parameters = np.concatenate([self._parameters, program.parameters])
        self._constants = np.concatenate([self._constants, program.settings])
        self._states = np.concatenate([self._states, np.zeros(program.states)])
        self._solvers = np.zeros((self._table.shape[0], chain.SOLVER_COLUMNS))
        self._motions = np.zeros((max(self._motions.shape[0], program.motions), ROWS, 1))
        self._forces = np.zeros((max(self._forces.shape[0], program.forces), 1))

    def is_good(self, damper: int | slice) -> np.ndarray:
        """Whether the last message brought a sample of the damper of this number that was used."""
        verdict = self.verdicts[damper]
        return (verdict < DUPLICATE) & (verdict > ABSENT)

    def sample(self, damper: int) -> np.ndarray:
        """The last sample of the damper of this number, (8,) in the rows of ``signals.layout``; a view."""
        return self._blocks[damper, :, 0]

    def step(self, stamp: int, values: np.ndarray, present: np.ndarray) -> int:
        """Runs the samples of one message; the results are in the attributes.

        Args:
            stamp: ns.
            values: (k,) displacement in m.
            present: (k,) bool, whether the message held the damper.

        Returns:
            How many estimates there are.
        """
        self._stamp[0] = stamp
        return _advance(
            self._kernels, self._table, self._parameters, self._constants, self._states, self._motions, self._forces,
            self._solvers, self._places, self._settings, self._max_gap, self._bounds, self._admission, self._filters,
            self._fusions, self._blocks, self._marks, self._stamp, self._value, self._dt, self._felt, self._alone,
            values, present, self.held, self.felt, self.felt_at, self.levels, self.counts, self.verdicts, self.status,
            self.modelled, self.estimates,
        )  # fmt: skip


@compiled
def _advance(
    kernels, table, parameters, constants, states, motions, forces, solvers, places, settings, max_gap, bounds,
    admission, filters, fusions, blocks, marks, stamp, value, dt, felt, alone, values, present, held, accelerations,
    felt_at, levels, counts, verdicts, status, modelled, estimates,
):  # fmt: skip
    """See ``LiveLine.step``; arrays as there."""
    given = np.empty(1)
    count = 0
    for d in range(values.size):
        if not present[d]:
            verdicts[d] = ABSENT
            continue
        value[0] = values[d]
        judge(stamp, value, max_gap[d], admission[d], verdicts[d : d + 1], dt)
        block = blocks[d]
        if verdicts[d] < DUPLICATE:
            count += 1
            if places[d, BEGUN] == 0:
                places[d, BEGUN], places[d, ORIGIN] = 1, stamp[0]
            block[T, 0] = (stamp[0] - places[d, ORIGIN]) / 1e9
            block[DT, 0] = dt[0]
            differentiate(settings[d, CUTOFF], dt, value, filters[d], block[X], block[V], block[A])
            alone[0] = 0
            if settings[d, NOISE] > 0.0:
                felt[0] = accelerations[d] if abs(stamp[0] - felt_at[d]) <= max_gap[d] else np.nan
                fuse(settings[d, NOISE:], dt, value, felt, fusions[d], block[X], block[V], block[A], alone)
            block[COMMAND:, 0] = held[:, d]
            if settings[d, LEAD] > 0.0:
                predict(settings[d, LEAD], block)
            _run_model(kernels, table, parameters, constants, states, motions, forces, solvers, places[d], block)
        watch(
            settings[d, NOISE_CUTOFF], stamp, value, verdicts[d : d + 1], alone, block, forces[0], bounds[d], marks[d],
            levels[d], counts[d], status[d : d + 1], given,
        )  # fmt: skip
        if verdicts[d] < DUPLICATE:
            estimates[_DISPLACEMENT, d], estimates[_VELOCITY, d] = block[X, 0], block[V, 0]
            estimates[_ACCELERATION, d], modelled[d] = block[A, 0], forces[0, 0]
            estimates[_FORCE, d], estimates[_STDDEV, d] = given[0], settings[d, STDDEV]
    return count


@compiled
def _run_model(kernels, table, parameters, constants, states, motions, forces, solvers, place, block):
    """One sample through one damper's program, force in ``forces[0]``; after one that is not finite it starts anew."""
    step = block[DT, 0]
    if place[RESTART]:
        block[DT, 0] = 0.0
    if block[DT, 0] <= 0.0:
        states[place[Z0] : place[Z1]] = 0.0
    chain.run(
        kernels, table[place[R0] : place[R1]], parameters, constants, block, motions[: place[MOTIONS]],
        forces[: place[FORCES]], states, solvers[place[R0] : place[R0] + place[SERIES] * (place[R1] - place[R0])],
        np.empty((0, 0)),
    )  # fmt: skip
    block[DT, 0] = step
    place[RESTART] = 0 if np.isfinite(forces[0, 0]) else 1
