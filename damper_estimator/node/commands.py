"""Currents that give wished forces: the inverse of a damper's model behind its estimate. Knows no ROS.

A wish is answered at once, at the last sample. Where samples come faster than wishes, a sample is answered with the
wish that holds when no wish came since the sample before. Where the wish is old or the estimate not good, the safe
current is commanded; before the first wish nothing is.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from damper_estimator.control import InverseModel
from damper_estimator.errors import InputError
from damper_estimator.model.estimator import EXTRAPOLATING, GOOD, Deployed
from damper_estimator.node.wire import float_message
from damper_estimator.signals import Channel
from damper_estimator.signals.layout import COMMAND, ROWS

COMMAND_TYPE = "std_msgs/msg/Float64"


class Rules(Protocol):
    """What the node's settings say about commands; see ``node.settings``."""

    safe_current: float
    wish_timeout: float
    command_extrapolating: bool


@dataclass
class CommandTally:
    """What became of one damper's wishes since the start; counts only ever grow.

    Attributes:
        wishes: that came.
        followed: commands whose force the wish is.
        limited: commands at the nearest force that can be reached.
        old, not_good, unanswered: safe currents, because the wish was old, the estimate not good, the inverse
            without an answer.
    """

    wishes: int = 0
    followed: int = 0
    limited: int = 0
    old: int = 0
    not_good: int = 0
    unanswered: int = 0

    @property
    def safe(self) -> int:
        """Safe currents."""
        return self.old + self.not_good + self.unanswered


class Follower:
    """What turns the wishes for one damper into currents; final.

    Attributes:
        name: of the damper.
        refusal: why its model has no inverse; "" where it has one.
        tally: counts.
        wanted: N, the last wish; NaN before the first.
        sent: the last command, in the unit of the command's messages; NaN before the first.
    """

    def __init__(self, name: str, deployed: Deployed, channel: Channel, horizon: float, lead: float) -> None:
        """``channel`` of the command, with its limits; ``horizon`` and ``lead`` in s, as `InverseModel`."""
        self.name, self.refusal, self.tally = name, "", CommandTally()
        self.wanted = self.sent = float("nan")
        self._wished = float("-inf")
        self._is_followed = False  # whether a wish came since the last sample
        self._channel = channel
        self._sample = np.zeros(ROWS)
        try:
            self._inverse = InverseModel(deployed.model, channel.value_limits, horizon, lead)
        except InputError as error:
            self.refusal = str(error)
        else:
            self._warm_up()

    def _warm_up(self) -> None:
        """Has the search compiled now, so that the first sample does not wait for it."""
        self._inverse.solve(self._sample, 0.0, slope=True)
        self._inverse.again(0.0)
        self._inverse.reset()

    def look(self, sample: np.ndarray) -> tuple[float, ...]:
        """Takes a sample (8,) in; reachable interval and slopes as `Inverse.reach`. Only where there is an inverse."""
        if np.isnan(sample[COMMAND]) and np.isfinite(self.sent):
            self._sample[:] = sample
            self._sample[COMMAND] = self._channel.value(self.sent)
            sample = self._sample
        return self._inverse.solve(sample, slope=True).reach

    def wish(self, force: float, now: float) -> None:
        """Takes a wish in N (NaN takes the last one back) at the steady time ``now``, s."""
        self.wanted, self._wished = force, now if np.isfinite(force) else float("-inf")
        self.tally.wishes += 1
        self._is_followed = True

    def is_due(self) -> bool:
        """Asked once per sample: whether the sample is answered without waiting for a wish."""
        due = self.tally.wishes > 0 and not self._is_followed
        self._is_followed = False
        return due and not self.refusal

    def command(self, status: int, now: float, rules: Rules) -> bytes | None:
        """The command for the last sample, serialised; None where the model has no inverse."""
        if self.refusal:
            return None
        tally = self.tally
        if now - self._wished > rules.wish_timeout:
            tally.old += 1
            return self.safe(rules)
        if status != GOOD and not (status == EXTRAPOLATING and rules.command_extrapolating):
            tally.not_good += 1
            return self.safe(rules)
        answer = self._inverse.again(self.wanted)
        if not np.isfinite(answer.current):
            tally.unanswered += 1
            return self.safe(rules)
        tally.followed += answer.reached
        tally.limited += not answer.reached
        return self._message(self._channel.raw(answer.current))

    def safe(self, rules: Rules) -> bytes | None:
        """The safe current; None where this damper was never commanded."""
        return None if self.refusal or not self.tally.wishes else self._message(rules.safe_current)

    def _message(self, current: float) -> bytes:
        self.sent = current
        return float_message(current)
