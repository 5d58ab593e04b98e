"""Health of the example controller, once a second (REP-107)."""

from diagnostic_msgs.msg import DiagnosticStatus

from damper_estimator.node.controlled_corner import CornerTally
from damper_estimator.node.diagnostic_status import OK, WARN, status


def corner_status(prefix: str, name: str, tally: CornerTally, before: CornerTally, desired: float) -> DiagnosticStatus:
    """Health of one damper's control; ``before`` is the tally of a period ago, ``desired`` the last force, N."""
    values = {
        "estimates": tally.estimates,
        "answered by the law": tally.acted,
        "answered with the limit: extrapolating": tally.limited,
        "passive: estimate not usable": tally.not_usable,
        "passive: no recent acceleration": tally.not_felt,
        "passive: no finite force": tally.not_finite,
        "estimates stopped": tally.silences,
        "accelerations rejected": tally.rejected,
        "added forces ignored": tally.ignored,
        "last desired force [N]": f"{desired:.4g}",
    }
    return status(f"{prefix}: {name}", *_judge(tally, before), values)


def _judge(tally: CornerTally, before: CornerTally) -> tuple[bytes, str]:
    estimates = tally.estimates - before.estimates
    if not estimates:
        return WARN, "no estimates; is the estimator running?"
    causes = {
        "the estimate was not usable": tally.not_usable - before.not_usable,
        "there was no recent acceleration of the body": tally.not_felt - before.not_felt,
        "the law's force was not finite": tally.not_finite - before.not_finite,
    }
    found = [f"{cause} ({count} of {estimates} estimates)" for cause, count in causes.items() if count]
    if found:
        return WARN, "passive: " + "; ".join(found)
    if tally.rejected > before.rejected:
        return WARN, f"{tally.rejected - before.rejected} accelerations were rejected"
    if tally.ignored > before.ignored:
        return WARN, f"{tally.ignored - before.ignored} added forces were ignored"
    return OK, "controlling"
