"""Input and output of a line: arrays over n messages and k dampers."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.runtime.damper_record import SLOW
from damper_estimator.runtime.estimates import FIELDS, Estimates
from damper_estimator.signals import Kinematics
from damper_estimator.signals.admission import DUPLICATE
from damper_estimator.signals.layout import ROWS

ABSENT = -1  # verdict on a damper that was not in the message


@dataclass(frozen=True, eq=False)
class LineInput:
    """The input at each of n messages, for k dampers.

    Attributes:
        stamp: (n,) int64 ns.
        displacement: (n, k) m; valid where ``present`` (n, k) bool.
        suspect: (n, k) uint8, 1 if the sample is doubtful for a reason outside the line: its sender, its age, or a
            current that contradicts its command.
        slow: (n, 3, k) last values of the slow channels in order of ``SLOW``, NaN before the first; ``received``:
            (n, 3, k) int64, number of messages of each so far.
        acceleration, acceleration_stamp: (n, k) m/s^2 and int64 ns, last values and stamps of the accelerometers.
    """

    stamp: np.ndarray
    displacement: np.ndarray
    present: np.ndarray
    suspect: np.ndarray
    slow: np.ndarray
    received: np.ndarray
    acceleration: np.ndarray
    acceleration_stamp: np.ndarray

    @classmethod
    def empty(cls, messages: int, dampers: int) -> "LineInput":
        """Messages that contain all dampers, without slow channels, to be filled."""
        n, k = messages, dampers
        return cls(
            np.zeros(n, np.int64), np.zeros((n, k)), np.ones((n, k), bool), np.zeros((n, k), np.uint8),
            np.full((n, len(SLOW), k), np.nan), np.zeros((n, len(SLOW), k), np.int64),
            np.full((n, k), np.nan), np.zeros((n, k), np.int64),
        )  # fmt: skip

    def with_another_damper(self) -> "LineInput":
        """The same with one more damper, without messages."""
        one = LineInput.empty(self.stamp.size, 1)
        joined = (
            np.concatenate([old, new], axis=-1) if old.ndim > 1 else old
            for old, new in zip(self.arrays(), one.arrays(), strict=True)
        )
        return LineInput(*joined)

    def arrays(self) -> tuple[np.ndarray, ...]:
        """The arrays in order of the attributes."""
        return (
            self.stamp, self.displacement, self.present, self.suspect, self.slow, self.received, self.acceleration,
            self.acceleration_stamp,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class LineOutput:
    """The output for each of n messages, for k dampers.

    Attributes:
        verdict: (n, k) int64, on each sample (``signals.admission``), or ABSENT. The others are valid where it is
            below DUPLICATE.
        status: (n, k) uint8; ``trusted``: the same regardless of the command's value (``status``).
        modelled: (n, k) N, the model's force; not finite if it gave none.
        numbers: (n, 9, k) numbers of damper_msgs/DamperForces by ``FIELDS``; the reachable forces are not set.
        blocks: (k, 8, n) samples in the rows of ``signals.layout``.
    """

    verdict: np.ndarray
    status: np.ndarray
    trusted: np.ndarray
    modelled: np.ndarray
    numbers: np.ndarray
    blocks: np.ndarray

    @classmethod
    def empty(cls, messages: int, dampers: int) -> "LineOutput":
        """Without estimates, to be filled."""
        n, k = messages, dampers
        return cls(
            np.full((n, k), ABSENT, np.int64), np.zeros((n, k), np.uint8), np.zeros((n, k), np.uint8),
            np.zeros((n, k)), np.full((n, len(FIELDS), k), np.nan), np.zeros((k, ROWS, n)),
        )  # fmt: skip

    def with_another_damper(self) -> "LineOutput":
        """The same with one more damper, without estimates."""
        one = LineOutput.empty(self.verdict.shape[0], 1)
        axes = (-1, -1, -1, -1, -1, 0)
        pairs = zip(self.arrays(), one.arrays(), axes, strict=True)
        return LineOutput(*(np.concatenate([old, new], axis) for old, new, axis in pairs))

    def arrays(self) -> tuple[np.ndarray, ...]:
        """The arrays in order of the attributes."""
        return self.verdict, self.status, self.trusted, self.modelled, self.numbers, self.blocks

    def of(self, damper: int, stamp: np.ndarray) -> Estimates:
        """The estimates of the damper of this number; ``stamp`` (n,) ns of the messages."""
        verdict = self.verdict[:, damper]
        good = (verdict > ABSENT) & (verdict < DUPLICATE)
        block = np.ascontiguousarray(self.blocks[damper][:, good])
        modelled = self.modelled[good, damper]
        return Estimates(
            Kinematics(stamp[good], block),
            np.where(np.isfinite(modelled), modelled, np.nan),
            self.numbers[good, FIELDS.index("force"), damper],
            self.numbers[good, FIELDS.index("force_stddev"), damper],
            self.status[good, damper],
            verdict[verdict > ABSENT],
        )
