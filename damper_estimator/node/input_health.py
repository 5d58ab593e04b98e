"""The health of the node's inputs once a second: counts since the start, judged by the last second."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticStatus

from damper_estimator.node.diagnostic_status import ERROR, OK, WARN, status

PUBLISHERS = "publishers"


@dataclass
class InputTally:
    """The messages of one topic; counts never decrease.

    Attributes:
        topic: resolved name.
        messages: received.
        malformed: messages that do not fit their type.
        failures: messages that the node could not process because of an internal error.
        lost: messages missing by their sequence numbers, between the first and the last received.
        reported_lost: messages that the middleware reports as lost.
        doubled: messages by damper that came from one of two publishers of it.
        publishers: present number.
        incompatible: publishers whose quality of service does not match the subscription.
        other_types: publishers of another message type.
        last: steady time of the last message, s; None before the first.
        names: of the last message whose structure was new.
        age: s, age of the last stamp on arrival; NaN before the first.
        late: samples that were too old on arrival.
        is_other_clock: whether the stamps are not of this machine's time.
    """

    topic: str
    messages: int = 0
    malformed: int = 0
    failures: int = 0
    lost: int = 0
    reported_lost: int = 0
    doubled: Mapping[str, int] = field(default_factory=dict)
    publishers: int = 0
    incompatible: int = 0
    other_types: int = 0
    last: float | None = None
    names: Sequence[str] = ()
    age: float = float("nan")
    late: int = 0
    is_other_clock: bool = False


def input_status(prefix: str, now: InputTally, before: InputTally, time: float, known: set[str]) -> DiagnosticStatus:
    """Health of one displacement topic.

    Args:
        prefix: the node's name.
        now, before: counts now and a period ago.
        time: steady time, s.
        known: names of the estimated dampers.
    """
    values = {
        "topic": now.topic,
        PUBLISHERS: now.publishers,
        "messages": now.messages,
        "lost": now.lost,
        "lost by the middleware": now.reported_lost,
        "from one of two publishers": ", ".join(f"{name}: {count}" for name, count in sorted(now.doubled.items())),
        "incompatible publishers": now.incompatible,
        "malformed": now.malformed,
        "failures": now.failures,
        "names not estimated": ", ".join(sorted(set(now.names) - known)),
        "age of the stamps on arrival [ms]": f"{1e3 * now.age:.1f}",
        "too old on arrival": now.late,
    }
    return status(f"{prefix}: input {now.topic}", *_judge_input(now, before, time), values)


def other_status(prefix: str, now: InputTally, before: InputTally) -> DiagnosticStatus:
    """Health of a topic that may be silent: a slow channel, a gauge, desired forces. Arguments as ``input_status``."""
    values = {
        "topic": now.topic,
        PUBLISHERS: now.publishers,
        "messages": now.messages,
        "incompatible publishers": now.incompatible,
        "malformed": now.malformed,
        "failures": now.failures,
    }
    receiving = OK, "no message yet" if now.last is None else "receiving"
    fault = _unreadable(now, before) or _malformed(now, before) or receiving
    return status(f"{prefix}: input {now.topic}", *fault, values)


def _unreadable(now: InputTally, before: InputTally) -> tuple[bytes, str] | None:
    """Why no message can be read; None if some are, or none is sent."""
    if now.incompatible and now.messages == before.messages:
        return (
            ERROR,
            "there is a publisher, but its quality of service does not match; set qos_reliability to best_effort",
        )
    if now.other_types and now.last is None:
        return ERROR, "there is a publisher, but of another type of message"
    if now.failures > before.failures:
        return ERROR, "messages could not be processed; the log has the traceback"
    return None


def _malformed(now: InputTally, before: InputTally) -> tuple[bytes, str] | None:
    count = now.malformed - before.malformed
    return (WARN, f"{count} messages do not fit their type") if count > 0 else None


def _judge_input(now: InputTally, before: InputTally, time: float) -> tuple[bytes, str]:
    unreadable = _unreadable(now, before)
    if unreadable is not None:
        return unreadable
    if now.last is None and now.publishers:
        return WARN, "there is a publisher, but it has not sent a message yet"
    if now.last is None:
        return WARN, "no message yet; check the topic, the namespace and ROS_DOMAIN_ID"
    if now.messages == before.messages:
        return ERROR, f"no message for {time - now.last:.1f} s"
    doubled = sorted(name for name, count in now.doubled.items() if count > before.doubled.get(name, 0))
    if doubled:
        return WARN, f"two publishers send {', '.join(doubled)} on {now.topic}; stop one or remap it"
    malformed = _malformed(now, before)
    if malformed is not None:
        return malformed
    lost = max(now.lost - before.lost, now.reported_lost - before.reported_lost)
    if lost > 0:
        return WARN, f"{lost} messages were lost on the way"
    if now.late > before.late:
        return WARN, f"{now.late - before.late} samples were too old on arrival; see max_age"
    if now.is_other_clock:
        return OK, "receiving; the stamps are another clock's, so their age cannot be judged"
    return OK, "receiving"
