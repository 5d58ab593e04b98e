"""The node's health once a second (REP-107): counts since the start, judged by the last second."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus

from damper_estimator.node.diagnostic_status import ERROR, OK, WARN, status
from damper_estimator.node.error_drift import Drift
from damper_estimator.node.input_health import PUBLISHERS, InputTally
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
from damper_estimator.signals.butterworth import LEAST_RATE

SUBSCRIBERS = "subscribers"


@dataclass(frozen=True, eq=False)
class DamperNow:
    """The state of one damper at one moment.

    Attributes:
        counts: by the constants of ``runtime.damper_record``.
        noise: m/s, standard deviation of the velocity.
        is_identified: whether the model was fitted to measurements.
        stamp: of the last used sample, ns.
        influential: the slow channels that the model's force depends on.
        slow: counts of the slow channels' topics, by role.
    """

    name: str
    model: str
    fitted_cutoff: float | None
    counts: np.ndarray
    noise: float
    is_identified: bool
    stamp: int
    influential: Sequence[str]
    slow: Mapping[str, InputTally]
    missing: int
    is_stale: bool
    drift: Drift | None


def before_first_sample(now: DamperNow) -> DamperNow:
    """The same damper before its first sample."""
    return replace(now, counts=np.zeros(COUNTS, np.int64), stamp=0, missing=0)


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
    return status(f"{prefix}: {now.name}", *_judge_damper(now, before, cutoff), values)


def _judge_damper(now: DamperNow, before: DamperNow, cutoff: float) -> tuple[bytes, str]:
    new = now.counts - before.counts
    samples, missing = int(new[: NON_FINITE + 1].sum()), now.missing - before.missing
    if new[NOT_FINITE]:
        return ERROR, "the model's force is not finite"
    if not samples and missing:
        return ERROR, "the messages do not contain this damper"
    dropped, resets = int(new[DUPLICATE : NON_FINITE + 1].sum()), int(new[GAP] + new[STEP_BACK])
    if now.is_stale and samples and dropped == samples:
        return ERROR, f"messages arrive, but none can be used; estimates are stale: {_dropped(new)}"
    if now.is_stale:
        return ERROR, "the input has stopped; estimates are stale"
    if not samples:
        return WARN, "no samples"
    warnings = [f"{dropped} of {samples} samples were dropped"] if dropped else []
    warnings += [f"gaps or clock steps: {resets} resets"] if resets else []
    warnings += [f"{missing} messages did not contain this damper"] if missing else []
    if new[JUMPS]:
        unit = "; it is faster than a damper nearly always: check its unit (scale in the signal map)"
        warnings.append(f"{new[JUMPS]} jumps of the displacement{unit if 2 * new[JUMPS] > samples else ''}")
    warnings += [f"{new[LATE]} gaps of several steps"] if new[LATE] else []
    warnings += ["the displacement is constant, although its sensor is noisy"] if new[STUCK] else []
    warnings += [f"{new[SUSPECT]} samples in doubt because of their age, sender or current"] if new[SUSPECT] else []
    warnings += _judge_rate(now, before, samples - dropped, cutoff)
    warnings += _judge_slow(now, new)
    warnings += [] if now.is_identified else ["the model was never identified: fit it to recordings of this damper"]
    if now.drift is not None and now.drift.is_alarm:
        warnings.insert(0, now.drift.sentence())
    warnings += ["the displacement is noisy"] if not warnings and new[BY_STATUS + DEGRADED] else []
    if warnings:
        return WARN, "; ".join(warnings)
    outside = int(new[BY_STATUS + EXTRAPOLATING])
    return OK, f"estimating; {outside} of {samples} samples outside the region of the fit" if outside else "estimating"


def _dropped(new: np.ndarray) -> str:
    """How many samples were dropped for which reason."""
    reasons = {DUPLICATE: "equal stamps", INVERSION: "older stamps", NON_FINITE: "values that are not finite"}
    return ", ".join(f"{new[row]} with {what}" for row, what in reasons.items() if new[row])


def _judge_rate(now: DamperNow, before: DamperNow, used: int, cutoff: float) -> list[str]:
    """Whether the samples are too rare for the filter: then the velocity between them is a guess."""
    seconds = (now.stamp - before.stamp) / 1e9
    least = LEAST_RATE * cutoff
    if not before.stamp or used < 2 or seconds <= 0.0 or used >= least * seconds:
        return []
    rate = used / seconds
    return [f"{rate:.0f} samples per second are too few for the filter of {cutoff:g} Hz: send {least:.0f}, or lower it"]


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
