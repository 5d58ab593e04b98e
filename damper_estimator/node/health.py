"""What the node says of itself once a second (REP-107): counts since the start, judged by the last second."""

from collections.abc import Sequence
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from damper_estimator.node.live_damper import LiveDamper
from damper_estimator.signals import Counts

SUBSCRIBERS = "subscribers"
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@dataclass
class InputTally:
    """What arrived on one displacement topic; counts only ever grow.

    Attributes:
        topic: resolved name.
        messages: received.
        failures: messages that the node could not process because of a bug of its own.
        lost: messages that the middleware reports as lost.
        incompatible: publishers whose quality of service does not match ours.
        last: steady time of the last message, s; None before the first.
        names: of the last message.
    """

    topic: str
    messages: int = 0
    failures: int = 0
    lost: int = 0
    incompatible: int = 0
    last: float | None = None
    names: Sequence[str] = ()


@dataclass(frozen=True)
class Glance:
    """Counts at one moment, to see what the last period added."""

    messages: int
    failures: int
    counts: Counts
    missing: int
    not_finite: int


def glance(tally: InputTally, damper: LiveDamper | None = None) -> Glance:
    """The counts of an input, and of a damper on it, as they are now."""
    return Glance(
        tally.messages,
        tally.failures,
        damper.counts if damper else Counts(),
        damper.missing if damper else 0,
        damper.not_finite if damper else 0,
    )


def input_status(prefix: str, tally: InputTally, before: Glance, now: float, known: set[str]) -> DiagnosticStatus:
    """Health of one displacement topic.

    Args:
        prefix: the node's name.
        tally, before: counts now and a period ago.
        now: steady time, s.
        known: names of the dampers that are estimated.
    """
    ignored = sorted(set(tally.names) - known)
    values = {
        "topic": tally.topic,
        "messages": tally.messages,
        "lost by the middleware": tally.lost,
        "incompatible publishers": tally.incompatible,
        "failures": tally.failures,
        "names not estimated": ", ".join(ignored),
    }
    return _status(f"{prefix}: input {tally.topic}", *_judge_input(tally, before, now), values)


def _judge_input(tally: InputTally, before: Glance, now: float) -> tuple[bytes, str]:
    if tally.incompatible and tally.last is None:
        return (
            ERROR,
            "a publisher is there, but its quality of service does not match; set qos_reliability to best_effort",
        )
    if tally.last is None:
        return WARN, "no message yet; check the topic, the namespace and ROS_DOMAIN_ID"
    if tally.messages == before.messages:
        return ERROR, f"no message for {now - tally.last:.1f} s"
    if tally.failures > before.failures:
        return ERROR, "messages could not be processed; the log has the traceback"
    return OK, "receiving"


def output_status(prefix: str, topic: str, published: int, subscribers: int) -> DiagnosticStatus:
    """Health of the force topic; that nobody listens is no fault."""
    values = {"topic": topic, "published": published, SUBSCRIBERS: subscribers}
    return _status(f"{prefix}: output", OK, "publishing" if subscribers else "nobody listens", values)


def damper_status(prefix: str, damper: LiveDamper, before: Glance, cutoff: float, delay: float) -> DiagnosticStatus:
    """Health of one damper; ``cutoff`` in Hz and ``delay`` in s are those of the filter in use."""
    counts = damper.counts
    fitted = damper.model.fit.get("cutoff")
    values = {
        "model": damper.model.name,
        "samples": counts.samples,
        "estimates": counts.samples - counts.dropped,
        "dropped: equal stamp": counts.duplicates,
        "dropped: older stamp": counts.inversions,
        "dropped: not finite": counts.non_finite,
        "resets: gap": counts.gaps,
        "resets: clock stepped back": counts.steps_back,
        "not in the message": damper.missing,
        "force not finite": damper.not_finite,
        "filter cutoff [Hz]": f"{cutoff:g}",
        "filter delay [ms]": f"{1e3 * delay:.2f}",
        "model identified at cutoff [Hz]": "" if fitted is None else f"{fitted:g}",
    }
    return _status(f"{prefix}: {damper.name}", *_judge_damper(damper, counts, before), values)


def _judge_damper(damper: LiveDamper, counts: Counts, before: Glance) -> tuple[bytes, str]:
    if damper.not_finite > before.not_finite:
        return ERROR, "the model gives no finite force"
    if counts.samples == before.counts.samples:
        missing = damper.missing > before.missing
        return (ERROR, "the messages do not hold this damper") if missing else (WARN, "no samples")
    dropped = counts.dropped - before.counts.dropped
    if dropped:
        return WARN, f"{dropped} of {counts.samples - before.counts.samples} samples were dropped"
    resets = counts.gaps + counts.steps_back - before.counts.gaps - before.counts.steps_back
    if resets:
        return WARN, f"gaps or clock steps: {resets} resets"
    if damper.missing > before.missing:
        return WARN, f"{damper.missing - before.missing} messages did not hold this damper"
    return OK, "estimating"


def _status(name: str, level: bytes, message: str, values: dict[str, object]) -> DiagnosticStatus:
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    return DiagnosticStatus(level=level, name=name, message=message, hardware_id="", values=pairs)
