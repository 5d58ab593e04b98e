"""The node's health once a second (REP-107): counts since the start, judged by the last second."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from socket import gethostname

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from damper_estimator.node.error_drift import Drift
from damper_estimator.runtime import (
    BY_STATUS,
    COUNTS,
    DEGRADED,
    EXTRAPOLATING,
    GOOD,
    IMPLAUSIBLE,
    JUMPS,
    LATE,
    NOT_FINITE,
    SILENT,
    SLOW,
    STUCK,
    SUSPECT,
    UNKNOWN,
    WARMING_UP,
)
from damper_estimator.signals.admission import DUPLICATE, GAP, INVERSION, NON_FINITE, STEP_BACK

HARDWARE = gethostname()
SUBSCRIBERS, PUBLISHERS = "subscribers", "publishers"
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


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


def _judge_input(now: InputTally, before: InputTally, time: float) -> tuple[bytes, str]:
    if now.incompatible and now.messages == before.messages:
        return (
            ERROR,
            "there is a publisher, but its quality of service does not match; set qos_reliability to best_effort",
        )
    if now.other_types and now.last is None:
        return ERROR, "there is a publisher, but of another type of message"
    if now.last is None and now.publishers:
        return WARN, "there is a publisher, but it has not sent a message yet"
    if now.last is None:
        return WARN, "no message yet; check the topic, the namespace and ROS_DOMAIN_ID"
    if now.messages == before.messages:
        return ERROR, f"no message for {time - now.last:.1f} s"
    if now.failures > before.failures:
        return ERROR, "messages could not be processed; the log has the traceback"
    doubled = sorted(name for name, count in now.doubled.items() if count > before.doubled.get(name, 0))
    if doubled:
        return WARN, f"two publishers send {', '.join(doubled)} on {now.topic}; stop one or remap it"
    if now.malformed > before.malformed:
        return WARN, f"{now.malformed - before.malformed} messages do not fit their type"
    lost = max(now.lost - before.lost, now.reported_lost - before.reported_lost)
    if lost > 0:
        return WARN, f"{lost} messages were lost on the way"
    if now.late > before.late:
        return WARN, f"{now.late - before.late} samples were too old on arrival; see max_age"
    if now.is_other_clock:
        return OK, "receiving; the stamps are another clock's, so their age cannot be judged"
    return OK, "receiving"


@dataclass(frozen=True, eq=False)
class DamperNow:
    """The state of one damper at one moment.

    Attributes:
        counts: by the constants of ``runtime.damper_record``.
        noise: m/s, standard deviation of the velocity.
        is_identified: whether the model was fitted to measurements.
        influential: the slow channels that the model's force depends on.
        slow: counts of the slow channels' topics, by role.
    """

    name: str
    model: str
    fitted_cutoff: float | None
    counts: np.ndarray
    noise: float
    is_identified: bool
    influential: Sequence[str]
    slow: Mapping[str, InputTally]
    missing: int
    is_stale: bool
    drift: Drift | None


def before_first_sample(now: DamperNow) -> DamperNow:
    """The same damper before its first sample."""
    return replace(now, counts=np.zeros(COUNTS, np.int64), missing=0)


def damper_status(prefix: str, now: DamperNow, before: DamperNow, cutoff: float, delay: float) -> DiagnosticStatus:
    """Health of one damper; ``cutoff`` in Hz of the filter, ``delay`` in s of the estimates."""
    counts = now.counts
    values = {
        "model": now.model,
        "samples": counts[: NON_FINITE + 1].sum(),
        "estimates": counts[:DUPLICATE].sum(),
        "dropped: equal stamp": counts[DUPLICATE],
        "dropped: older stamp": counts[INVERSION],
        "dropped: not finite": counts[NON_FINITE],
        "resets: gap": counts[GAP],
        "resets: clock stepped back": counts[STEP_BACK],
        "late: several steps at once": counts[LATE],
        "jumps": counts[JUMPS],
        "not in the message": now.missing,
        "force not finite": counts[NOT_FINITE],
        "estimates: good": counts[BY_STATUS + GOOD],
        "estimates: warming up": counts[BY_STATUS + WARMING_UP],
        "estimates: extrapolating": counts[BY_STATUS + EXTRAPOLATING],
        "estimates: degraded": counts[BY_STATUS + DEGRADED],
        "samples in doubt (age, sender, current)": counts[SUSPECT],
        "samples while stuck": counts[STUCK],
        **{f"{role}: values that cannot be": counts[IMPLAUSIBLE + row] for row, role in enumerate(SLOW)},
        **{f"{role}: samples while silent": counts[SILENT + row] for row, role in enumerate(SLOW)},
        **{f"{role}: samples before the first value": counts[UNKNOWN + row] for row, role in enumerate(SLOW)},
        **{f"{role}: {PUBLISHERS}": tally.publishers for role, tally in now.slow.items()},
        "noise of the velocity [m/s]": f"{now.noise:.3g}",
        "filter cutoff [Hz]": f"{cutoff:g}",
        "filter delay [ms]": f"{1e3 * delay:.2f}",
        "model identified at cutoff [Hz]": "" if now.fitted_cutoff is None else f"{now.fitted_cutoff:g}",
    }
    if now.drift is not None:
        values |= {
            "error against the gauge [N rms]": f"{now.drift.rms_n:.4g}",
            "error against the gauge [%]": f"{100 * now.drift.error:.1f}",
            "error at the beginning [%]": f"{100 * now.drift.reference:.1f}",
        }
    return status(f"{prefix}: {now.name}", *_judge_damper(now, before), values)


def _judge_damper(now: DamperNow, before: DamperNow) -> tuple[bytes, str]:
    new = now.counts - before.counts
    samples, missing = int(new[: NON_FINITE + 1].sum()), now.missing - before.missing
    if new[NOT_FINITE]:
        return ERROR, "the model's force is not finite"
    if not samples and missing:
        return ERROR, "the messages do not contain this damper"
    if now.is_stale:
        return ERROR, "the input has stopped; estimates are stale"
    if not samples:
        return WARN, "no samples"
    dropped, resets = int(new[DUPLICATE : NON_FINITE + 1].sum()), int(new[GAP] + new[STEP_BACK])
    warnings = [f"{dropped} of {samples} samples were dropped"] if dropped else []
    warnings += [f"gaps or clock steps: {resets} resets"] if resets else []
    warnings += [f"{missing} messages did not contain this damper"] if missing else []
    warnings += [f"{new[JUMPS]} jumps of the displacement"] if new[JUMPS] else []
    warnings += [f"{new[LATE]} gaps of several steps"] if new[LATE] else []
    warnings += ["the displacement is constant, although its sensor is noisy"] if new[STUCK] else []
    warnings += [f"{new[SUSPECT]} samples in doubt because of their age, sender or current"] if new[SUSPECT] else []
    warnings += _judge_slow(now, new)
    warnings += [] if now.is_identified else ["the model was never identified: fit it to recordings of this damper"]
    if now.drift is not None and now.drift.is_alarm:
        warnings.insert(0, now.drift.sentence())
    warnings += ["the displacement is noisy"] if not warnings and new[BY_STATUS + DEGRADED] else []
    if warnings:
        return WARN, "; ".join(warnings)
    outside = int(new[BY_STATUS + EXTRAPOLATING])
    return OK, f"estimating; {outside} of {samples} samples outside the region of the fit" if outside else "estimating"


def _judge_slow(now: DamperNow, new: np.ndarray) -> list[str]:
    warnings = []
    for row, role in enumerate(SLOW):
        effect = "the force depends on it" if role in now.influential else "the force does not depend on it"
        if new[IMPLAUSIBLE + row]:
            warnings.append(f"{new[IMPLAUSIBLE + row]} implausible values of {role} were dropped ({effect})")
        if new[UNKNOWN + row] and role in now.influential:
            warnings.append(_unknown(role, now.slow[role]))
        if new[SILENT + row]:
            warnings.append(f"{role} is silent, its last value is kept ({effect})")
    return warnings


def _unknown(role: str, tally: InputTally) -> str:
    """Why a slow channel has no value yet."""
    reason = "it has no publisher"
    if tally.incompatible:
        reason = "the quality of service of its publisher does not match; set qos_reliability to best_effort"
    elif tally.publishers:
        reason = "its publisher has sent no value that can be read"
    return f"no {role} yet on {tally.topic}, and the force depends on it: {reason}"


def output_status(
    prefix: str, values: Mapping[str, object], incompatible: int, clock_has_stopped: bool = False
) -> DiagnosticStatus:
    """Health of the force topic; no subscriber is no fault. ``values`` has ``SUBSCRIBERS``."""
    if clock_has_stopped:
        what = (
            "/clock stands still while messages arrive: time goes on at this machine's pace; set use_sim_time to false"
        )
        return status(f"{prefix}: output", ERROR, what, values)
    if incompatible:
        return status(
            f"{prefix}: output", WARN, "a subscriber requests a quality of service that is not offered", values
        )
    return status(f"{prefix}: output", OK, "publishing" if values[SUBSCRIBERS] else "no subscriber", values)


def status(name: str, level: bytes, message: str, values: Mapping[str, object]) -> DiagnosticStatus:
    """One status with its values as text."""
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    return DiagnosticStatus(level=level, name=name, message=message, hardware_id=HARDWARE, values=pairs)
