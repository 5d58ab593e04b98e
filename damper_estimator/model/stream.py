"""Runs a model on blocks of samples, carrying its state: the one way forces are computed, live and off line."""

import numpy as np

from damper_estimator.model import chain
from damper_estimator.model.program import Program
from damper_estimator.signals.layout import DT

_NO_TRACE = np.zeros((0, 0))


class Stream:
    """The running state of one model. Blocks of any size, also of one sample, give the same forces bit for bit."""

    def __init__(self, program: Program):
        """``program`` from ``compile_program``; several streams may share one."""
        self._program = program
        self._state = np.zeros(program.states)
        self._solvers = np.zeros((program.table.shape[0] if program.series else 0, chain.SOLVER_COLUMNS))
        self._registers: tuple[np.ndarray, np.ndarray] | None = None
        self._restart = False

    def force(self, block: np.ndarray) -> np.ndarray:
        """Forces (n,) in N of the next samples, ``block`` (8, n) in the rows of ``signals.layout``; resets where
        dt is 0.
        """
        return self._run(block, _NO_TRACE)

    def contributions(self, block: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces (n,) and what each entry of the model contributed to them, (entries, n) in order of ``walk``.

        They add up to the force; what stands behind a compliance is counted there as a whole.
        """
        trace = np.zeros((self._program.table.shape[0], block.shape[1]))
        force = self._run(block, trace)
        return force, trace[list(self._program.rows)]

    def _run(self, block: np.ndarray, trace: np.ndarray) -> np.ndarray:
        """Runs the stretches between resets; a force that is not finite resets the model, and the next sample
        starts anew.
        """
        block, size = np.ascontiguousarray(block), block.shape[1]
        starts = np.flatnonzero(block[DT] <= 0.0)
        force = np.empty(size)
        first, length = 0, size
        while first < size:
            following = np.searchsorted(starts, first, side="right")
            last = min(first + length, int(starts[following]) if following < starts.size else size)
            part = np.ascontiguousarray(block[:, first:last]) if last - first < size else block
            if self._restart and part[DT, 0] > 0.0:
                part = part.copy()
                part[DT, 0] = 0.0
            self._restart = False
            part_trace = trace if last - first == size else np.zeros((trace.shape[0], last - first))
            force[first:last] = self._stretch(part, part_trace)
            lost = np.flatnonzero(~np.isfinite(force[first:last]))
            if lost.size:
                last, length = first + int(lost[0]) + 1, 1
                self._restart = True
            else:
                length = max(2 * length, 2)
            if trace.size and part_trace is not trace:
                trace[:, first:last] = part_trace[:, : last - first]
            first = last
        return force

    def _stretch(self, block: np.ndarray, trace: np.ndarray) -> np.ndarray:
        program, size = self._program, block.shape[1]
        if block[DT, 0] <= 0.0:
            self._state[:] = 0.0
        if self._registers is None or self._registers[1].shape[1] != size:
            self._registers = (
                np.empty((program.motions, block.shape[0], size)),
                np.empty((program.forces, size)),
            )
        motions, forces = self._registers
        chain.run(
            program.kernels,
            program.table,
            program.parameters,
            program.settings,
            block,
            motions,
            forces,
            self._state,
            self._solvers,
            trace,
        )
        return forces[0].copy()
