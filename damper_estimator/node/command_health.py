"""Health of the commanded currents of one damper, as a diagnostic status."""

from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus

from damper_estimator.node.diagnostic_status import OK, WARN, status
from damper_estimator.node.force_follower import CommandTally


@dataclass(frozen=True)
class CommandNow:
    """The state of one damper's commands at one moment; forces in N, ``sent`` as in the messages."""

    name: str
    refusal: str
    tally: CommandTally
    desired: float
    sent: float
    complaint: str = ""


def command_status(prefix: str, now: CommandNow, before: CommandTally) -> DiagnosticStatus:
    """Health of the commands for one damper with desired forces; ``before`` is the tally of a period ago."""
    tally = now.tally
    values = {
        "desired forces": tally.desired,
        "commands: desired force reached": tally.followed,
        "commands: nearest force": tally.limited,
        "safe current: desired force too old": tally.old,
        "safe current: estimate not good": tally.not_good,
        "safe current: no answer": tally.unanswered,
        "last desired force [N]": f"{now.desired:.4g}",
        "last command": f"{now.sent:.4g}",
    }
    return status(f"{prefix}: {now.name} command", *_judge_command(now, before), values)


def _judge_command(now: CommandNow, before: CommandTally) -> tuple[bytes, str]:
    if now.refusal:
        return WARN, f"desired forces cannot be followed: {now.refusal}"
    tally = now.tally
    causes = {
        "the desired force was too old": tally.old - before.old,
        "the estimate was not good": tally.not_good - before.not_good,
        "the inverse had no answer": tally.unanswered - before.unanswered,
    }
    warnings = [f"{cause} ({count} commands)" for cause, count in causes.items() if count]
    if warnings:
        return WARN, "; ".join(["safe current: " + "; ".join(warnings), *filter(None, [now.complaint])])
    if now.complaint:
        return WARN, now.complaint
    if tally.desired == before.desired:
        return WARN, "desired forces have stopped"
    return OK, "following desired forces"
