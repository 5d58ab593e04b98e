"""Runs a model on blocks of samples with a carried state; the only way to compute forces, live and offline."""

import numpy as np

from damper_estimator.model import chain
from damper_estimator.model.program import Program

_NO_TRACE = np.zeros((0, 0))


class Stream:
    """The running state of one model. Blocks of any size, down to one sample, produce the same forces bit for bit."""

    def __init__(self, program: Program):
        """``program`` from ``compile_program``; several streams can share one."""
        self._program = program
        self._state = np.zeros(program.states)
        self._restart = np.zeros(1)

    def force(self, block: np.ndarray) -> np.ndarray:
        """Forces (n,) in N of the next samples, ``block`` (8, n) in the rows of ``signals.layout``.

        A step of 0 or a non-finite force resets the state.
        """
        return self._run(block, _NO_TRACE)

    def contributions(self, block: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces (n,) and the contribution of each entry of the model, (entries, n) in order of ``walk``.

        They add up to the force; a compliance includes everything behind it.
        """
        trace = np.zeros((self._program.table.shape[0], block.shape[1]))
        force = self._run(block, trace)
        return force, trace[list(self._program.rows)]

    def _run(self, block: np.ndarray, trace: np.ndarray) -> np.ndarray:
        program, force = self._program, np.empty(block.shape[1])
        chain.run_with_resets(
            program.functions, program.table, program.parameters, program.settings, np.ascontiguousarray(block),
            program.motions, program.forces, self._state, int(program.series), self._restart, trace, force,
        )  # fmt: skip
        return force
