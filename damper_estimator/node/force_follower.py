"""Currents for desired forces, by the inverse of a damper's model after its estimate. Independent of ROS.

A desired force is answered immediately, at the last sample. If no desired force came since the previous sample, a
sample is answered with the last one. If the desired force is old or the estimate is not trusted, the safe current is
commanded; before the first desired force nothing is commanded.

Whether the estimate is trusted does not depend on where the present command lies in the region of the fit: the safe
current itself can lie outside it, and would otherwise keep the damper passive forever.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from damper_estimator.control import InverseModel, checked_limits, usable_limits
from damper_estimator.errors import InputError
from damper_estimator.node.current_check import CurrentCheck
from damper_estimator.runtime import EXTRAPOLATING, GOOD, STALE, Deployed
from damper_estimator.signals.layout import COMMAND, ROWS

# Source of a command: the constants of damper_msgs/DamperCommand.
FOLLOWED, LIMITED, SAFE_OLD, SAFE_NOT_TRUSTED, SAFE_UNANSWERED, SAFE_STOPPED, IDLE = range(7)


class Rules(Protocol):
    """The node's settings about commands; see ``node.settings``."""

    safe_current: float
    desired_force_timeout: float
    command_extrapolating: bool
    command_lag: float
    horizon: float
    lead: float


class Command(NamedTuple):
    """One command for one damper.

    Attributes:
        damper: its name.
        stamp: ns, of the sample that it answers; 0 before the first.
        current: in the unit of the command's messages.
        desired, achievable: N; NaN if there is none.
        source: one of the constants above.
    """

    damper: str
    stamp: int
    current: float
    desired: float
    achievable: float
    source: int


@dataclass
class CommandTally:
    """The outcome of one damper's desired forces since the start; counts never decrease.

    Attributes:
        desired: received desired forces.
        followed: commands that reach the desired force.
        limited: commands at the nearest force that can be reached.
        old, not_good, unanswered: safe currents, because the desired force was old, the estimate was not trusted, or
            the inverse had no answer.
    """

    desired: int = 0
    followed: int = 0
    limited: int = 0
    old: int = 0
    not_good: int = 0
    unanswered: int = 0


class ForceFollower:
    """Follows the desired forces of one damper by currents; final.

    Attributes:
        name: of the damper.
        refusal: why its model has no inverse; "" if it has one.
        warnings: consequences of its limits and the safe current for the region of the fit, in words.
        tally: counts.
        desired: N, the last desired force; NaN before the first.
        sent: the last command, in the unit of the command's messages; NaN before the first.
        sent_at: steady time of it, s.
        current: comparison of the current that its driver reports with the commands.
    """

    def __init__(self, name: str, deployed: Deployed, rules: Rules) -> None:
        """Raises InputError as `usable_limits`, and if the safe current lies outside the driver's limits."""
        self.name, self.refusal, self.tally = name, "", CommandTally()
        self.warnings: tuple[str, ...] = ()
        self.desired = self.sent = float("nan")
        self.sent_at = self._requested = float("-inf")
        self._is_followed = False  # whether a desired force came since the last sample
        self._channel = channel = deployed.signals.command
        self._sample = np.zeros(ROWS)
        self._deployed = deployed
        try:
            low, high = checked_limits(deployed.model, channel.value_limits)
        except InputError as error:
            self.refusal, self.current = str(error), CurrentCheck(float("nan"), 0.0)
            return
        self.current = CurrentCheck(high - low, rules.command_lag)
        limits, narrowed = usable_limits(name, deployed, rules.command_extrapolating)
        self.warnings = (*self.check_safe_current(rules.safe_current), *narrowed)
        self._inverse = InverseModel(deployed.model, limits, rules.horizon, rules.lead)
        self._warm_up()

    def check_safe_current(self, safe_current: float) -> tuple[str, ...]:
        """Warnings about a safe current; raises InputError if the driver cannot set it."""
        if self.refusal:
            return ()
        channel = self._channel
        (low, high), safe = self._deployed.bounds[COMMAND], float(channel.value(safe_current))
        limits, unit = channel.value_limits, channel.unit or "A"
        if limits is not None and not limits[0] <= safe <= limits[1]:
            raise InputError(
                f"{self.name}: the safe current {safe:g} {unit} lies outside the limits {limits[0]:g} to {limits[1]:g} "
                f"{unit} of the command; set the parameter safe_current, or the limits in the signal map"
            )
        if low <= safe <= high:
            return ()
        return (
            f"the safe current {safe:g} {unit} lies outside the region {low:g} to {high:g} {unit} that the model was "
            "fitted on: EXTRAPOLATING while it flows",
        )

    def _warm_up(self) -> None:
        """Compiles the search now, so that the first sample does not wait for it."""
        self._inverse.solve(self._sample, 0.0, slope=True)
        self._inverse.again(0.0)
        self._inverse.reset()

    def update(self, sample: np.ndarray, is_trusted: bool = True) -> tuple[float, ...]:
        """Takes a sample (8,); returns reachable interval and slopes as `Inverse.reach`. Only without a refusal.

        Args:
            is_trusted: whether the sample may count for how much force the current usually makes.
        """
        if np.isnan(sample[COMMAND]) and np.isfinite(self.sent):
            self._sample[:] = sample
            self._sample[COMMAND] = self._channel.value(self.sent)
            sample = self._sample
        return self._inverse.solve(sample, slope=True, is_trusted=is_trusted).reach

    def request(self, force: float, now: float) -> None:
        """Takes a desired force in N (NaN withdraws the last one) at the steady time ``now``, s."""
        self.desired, self._requested = force, now if np.isfinite(force) else float("-inf")
        self.tally.desired += 1
        self._is_followed = True

    def drop_desired_force(self) -> None:
        """The last desired force no longer counts, and the next command is due."""
        self.sent_at = self._requested = float("-inf")

    def is_due(self) -> bool:
        """Called once per sample: whether the sample is answered without waiting for a desired force."""
        due = self.tally.desired > 0 and not self._is_followed
        self._is_followed = False
        return due and not self.refusal

    def command(self, status: int, stamp: int, now: float, rules: Rules) -> Command | None:
        """The command for the last sample; None if the model has no inverse. Arguments as `_answer`."""
        if self.refusal:
            return None
        command = self._answer(status, stamp, now, rules)
        self.current.note_command(float(self._channel.value(command.current)), now)
        return command

    def _answer(self, status: int, stamp: int, now: float, rules: Rules) -> Command:
        """The command for the last sample.

        Args:
            status: decides whether the damper is commanded (``DisplacementInput.trusted``).
            stamp: ns, of the sample.
            now: steady time, s.
            rules: present settings.
        """
        tally, self.sent_at = self.tally, now
        if not 0.0 <= now - self._requested <= rules.desired_force_timeout:
            tally.old += 1
            return self._safe(stamp, rules, SAFE_OLD)
        if status != GOOD and not (status == EXTRAPOLATING and rules.command_extrapolating):
            tally.not_good += 1
            return self._safe(stamp, rules, SAFE_STOPPED if status == STALE else SAFE_NOT_TRUSTED)
        answer = self._inverse.again(self.desired)
        if not np.isfinite(answer.current):
            tally.unanswered += 1
            return self._safe(stamp, rules, SAFE_UNANSWERED)
        tally.followed += answer.reached
        tally.limited += not answer.reached
        self.sent = self._channel.raw(answer.current)
        source = FOLLOWED if answer.reached else LIMITED
        return Command(self.name, stamp, self.sent, self.desired, answer.expected, source)

    def safe(self, stamp: int, rules: Rules) -> Command | None:
        """The safe current; None if this damper was never commanded."""
        return None if self.refusal or not self.tally.desired else self._safe(stamp, rules, SAFE_STOPPED)

    def idle(self, stamp: int, rules: Rules) -> Command | None:
        """The command before the first desired force, for drivers that expect messages; None after it."""
        if self.refusal or self.tally.desired:
            return None
        return Command(self.name, stamp, rules.safe_current, float("nan"), float("nan"), IDLE)

    def _safe(self, stamp: int, rules: Rules, source: int) -> Command:
        self.sent = rules.safe_current
        return Command(self.name, stamp, self.sent, self.desired, float("nan"), source)
