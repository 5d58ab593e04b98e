"""The inverse of a damper's model, sample by sample: the command for a desired force.

    inverse = InverseModel(model, (0.0, 2.0))
    answer = inverse.solve(sample, wanted=800.0)      # sample (8,): one column of a block of kinematics
    answer.current, answer.force_min, answer.force_max

A command acts after the sample at which it is chosen. The state therefore follows the samples with the actual commands,
and a copy of it predicts the force of each command after ``horizon`` seconds, for the motion ``lead`` seconds later
(acceleration held). This inverts a lag tau of the coil within the limits of the current: changes are amplified by
1 / (1 - exp(-horizon / tau)), with a short horizon up to the limit until the lag has settled. A short horizon tracks
an exact model closely; if model and damper differ, it overshoots and chatters, and a horizon as long as the lag tracks
better (docs/control.md). ``lead`` compensates the delay of filter, sensors and driver.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.control import command_search
from damper_estimator.control.influence import checked_limits
from damper_estimator.model import DamperModel, chain
from damper_estimator.signals.layout import COMMAND, DT, ROWS

HORIZON, LEAD = 0.03, 0.01
"""s, defaults: measured on simulated magneto-rheological dampers with a lag of 20 ms behind a filter of 60 Hz."""


@dataclass(frozen=True)
class Inverse:
    """The answer to one sample; forces in N, NaN if there is none.

    Attributes:
        force: of the model at the sample, with the command of the sample; bit for bit that of a `Stream`.
        current: the command (A, or the model's unit of the command), within the limits; NaN without a
            desired force.
        expected: its force after the horizon; the nearest one if the desired force is out of reach.
        force_min, force_max: reachable range after the horizon, including the lag, as far as searched.
        dforce_dcurrent: N/A, slope at ``current`` of the force reached after the horizon (mean slope without a
            desired force).
        dforce_dvelocity: N s/m, partial derivative there; NaN unless requested.
        reached: whether ``expected`` is the desired force.
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
        """``limits`` of the command; None for those of the model's fit.

        Raises:
            InputError: if the model's force does not depend on the command, and as in `checked_limits`.
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
        self._memory, self._out = np.zeros(command_search.MEMORY), np.zeros(command_search.RESULTS)
        self.reset()

    def reset(self) -> None:
        """Resets the state for the next sample."""
        self._memory[:] = 0.0
        self._memory[command_search.LAST] = np.nan
        self._restart = True

    def solve(
        self, sample: np.ndarray, wanted: float = np.nan, slope: bool = False, is_trusted: bool = True
    ) -> Inverse:
        """Processes one sample and finds the command for the time after it.

        Args:
            sample: (8,) in the rows of ``signals.layout``; its command is the present one, NaN for the last result.
                A step of 0 resets the model.
            wanted: N, positive where it resists extension; NaN if there is no desired force.
            slope: whether to compute dforce_dvelocity, which needs one more evaluation.
            is_trusted: whether the sample counts for the largest influence of the command, below a share of which the
                command is kept; after one wild sample it would be kept for good.
        """
        column, span = self._sample, self._memory[command_search.SPAN]
        column[:, 0] = sample
        if np.isnan(column[COMMAND, 0]):
            column[COMMAND, 0] = self._memory[command_search.LAST]
        if self._restart:
            column[DT, 0] = 0.0
        answer = self._answer(True, wanted, slope)
        if not is_trusted:
            self._memory[command_search.SPAN] = span
        return answer

    def reach(self, block: np.ndarray) -> np.ndarray:
        """Processes a block (8, n); returns reachable forces and slopes after each sample, (4, n) in the order of
        `Inverse.reach`, without a desired force."""
        return np.array([self.solve(column, slope=True).reach for column in block.T]).reshape(-1, 4).T

    def again(self, wanted: float, slope: bool = False) -> Inverse:
        """The result for another desired force (N) at the last sample, as from `solve`; NaN before the first sample."""
        return self._answer(False, wanted, slope)

    def _answer(self, is_new: bool, wanted: float, slope: bool) -> Inverse:
        command_search.invert(
            *self._machine, self._sample, is_new, self._ahead, self._state, self._trial, self._limits, self._reach,
            wanted, slope, self._memory, self._out,
        )  # fmt: skip
        out = self._out.tolist()
        self._restart = not np.isfinite(out[command_search.FORCE])
        return Inverse(
            force=out[command_search.FORCE],
            current=out[command_search.CURRENT],
            expected=out[command_search.EXPECTED],
            force_min=out[command_search.LOWEST],
            force_max=out[command_search.HIGHEST],
            dforce_dcurrent=out[command_search.SLOPE_CURRENT],
            dforce_dvelocity=out[command_search.SLOPE_VELOCITY],
            reached=out[command_search.REACHED] > 0.0,
            evaluations=int(out[command_search.EVALUATIONS]),
        )
