"""The inverse of a damper's model, sample by sample: the command that gives a wanted force.

    inverse = InverseModel(model, (0.0, 2.0))
    answer = inverse.solve(sample, wanted=800.0)      # sample (8,): one column of a block of kinematics
    answer.current, answer.force_min, answer.force_max

A command acts after the sample at which it is chosen. So the state follows the samples with the commands that were in
force, and on a copy of it the model is asked which force each command will have reached ``horizon`` seconds later, at
the motion ``lead`` seconds later (acceleration held). A lag tau of the coil is thereby inverted within the limits of
the current: changes are pushed by 1 / (1 - exp(-horizon / tau)), for a short horizon to the limit until the lag has
caught up. Short follows an exact model closely; where model and damper differ it overshoots and chatters, and a horizon
as long as the lag tracks better (docs/control.md). ``lead`` makes up for what filter, sensors and driver are late.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.control import search
from damper_estimator.control.influence import checked_limits
from damper_estimator.model import DamperModel, chain
from damper_estimator.signals.layout import COMMAND, DT, ROWS

HORIZON, LEAD = 0.03, 0.01
"""s, defaults: measured on simulated magneto-rheological dampers with a lag of 20 ms behind a filter of 60 Hz."""


@dataclass(frozen=True)
class Inverse:
    """The answer to one sample; forces in N, NaN where there is none.

    Attributes:
        force: of the model at the sample, with the command that the sample holds; bit for bit that of a `Stream`.
        current: to be commanded (A, or the model's unit of the command), within the limits; NaN where none
            is desired.
        expected: force that it will have reached after the horizon; the nearest one where the desired one cannot be.
        force_min, force_max: what can be reached after the horizon, the lag counted; what the search saw.
        dforce_dcurrent: N/A, slope at ``current`` of the force reached after the horizon (mean slope where no force
            is desired).
        dforce_dvelocity: N s/m, partial derivative there; NaN unless asked for.
        reached: whether ``expected`` is the wanted force.
        evaluations: of the model, for this sample.
    """

    force: float
    current: float
    expected: float
    force_min: float
    force_max: float
    dforce_dcurrent: float
    dforce_dvelocity: float
    reached: bool
    evaluations: int

    @property
    def reach(self) -> tuple[float, float, float, float]:
        """force_min, force_max, dforce_dvelocity, dforce_dcurrent: in the order of damper_msgs/DamperForces."""
        return self.force_min, self.force_max, self.dforce_dvelocity, self.dforce_dcurrent


class InverseModel:
    """The running inverse of one damper's model; final.

    Attributes:
        limits: lowest and highest command.
        horizon, lead: s.
    """

    def __init__(
        self,
        model: DamperModel,
        limits: tuple[float, float] | None = None,
        horizon: float = HORIZON,
        lead: float = LEAD,
    ):
        """``limits`` of the command; None takes those of the recordings that the model was fitted on.

        Raises:
            InputError: where the model's force does not depend on the command, and as in `checked_limits`.
        """
        if not (0.0 < horizon <= 1.0 and 0.0 <= lead <= 1.0):
            raise ValueError(f"horizon {horizon:g} s must be above 0 and lead {lead:g} s not below; both at most 1 s")
        self.limits = checked_limits(model, limits)
        self.horizon, self.lead = horizon, lead
        program = model.program
        self._machine = (
            program.functions,
            program.table,
            program.parameters,
            program.settings,
            np.empty((program.motions, ROWS, 1)),
            np.empty((program.forces, 1)),
            np.zeros((program.table.shape[0] if program.series else 0, chain.SOLVER_COLUMNS)),
            np.zeros((0, 0)),
        )
        self._sample, self._ahead = np.full((ROWS, 1), np.nan), np.empty((ROWS, 1))
        self._state, self._trial = np.zeros(program.states), np.zeros(program.states)
        self._limits, self._reach = np.array(self.limits), np.array([horizon, lead])
        self._memory, self._out = np.zeros(search.MEMORY), np.zeros(search.RESULTS)
        self.reset()

    def reset(self) -> None:
        """The next sample starts anew."""
        self._memory[:] = 0.0
        self._memory[search.LAST] = np.nan
        self._restart = True

    def solve(self, sample: np.ndarray, wanted: float = np.nan, slope: bool = False) -> Inverse:
        """Takes one sample in and answers for the time after it.

        Args:
            sample: (8,) in the rows of ``signals.layout``; its command is what was in force until now, NaN takes the
                last answer. A step of 0 starts the model anew.
            wanted: N, positive where it resists extension; NaN where there is no desired force.
            slope: whether dforce_dvelocity is wanted, which costs one more evaluation.
        """
        column = self._sample
        column[:, 0] = sample
        if np.isnan(column[COMMAND, 0]):
            column[COMMAND, 0] = self._memory[search.LAST]
        if self._restart:
            column[DT, 0] = 0.0
        return self._answer(True, wanted, slope)

    def reach(self, block: np.ndarray) -> np.ndarray:
        """Takes the samples of a block (8, n) in; what could be reached after each and the slopes there, (4, n) in the
        order of `Inverse.reach`. Without a desired force, so that it does not depend on any."""
        return np.array([self.solve(column, slope=True).reach for column in block.T]).reshape(-1, 4).T

    def again(self, wanted: float, slope: bool = False) -> Inverse:
        """Answers another desired force (N) at the last sample, as `solve` would have; NaN before the first sample."""
        return self._answer(False, wanted, slope)

    def _answer(self, is_new: bool, wanted: float, slope: bool) -> Inverse:
        search.invert(
            *self._machine, self._sample, is_new, self._ahead, self._state, self._trial, self._limits, self._reach,
            wanted, slope, self._memory, self._out,
        )  # fmt: skip
        out = self._out.tolist()
        self._restart = not np.isfinite(out[search.FORCE])
        return Inverse(
            force=out[search.FORCE],
            current=out[search.CURRENT],
            expected=out[search.EXPECTED],
            force_min=out[search.LOWEST],
            force_max=out[search.HIGHEST],
            dforce_dcurrent=out[search.SLOPE_CURRENT],
            dforce_dvelocity=out[search.SLOPE_VELOCITY],
            reached=out[search.REACHED] > 0.0,
            evaluations=int(out[search.EVALUATIONS]),
        )
