"""Defects of single channels: gaps, stamps, limits, dead or repeated values, steps too coarse, rate too low."""

from collections.abc import Iterator

import numpy as np

from damper_estimator.signals import DEFAULT_MAX_GAP, Measurement
from damper_estimator.signals.butterworth import LEAST_RATE, STATE_SIZE, differentiate
from damper_estimator.signals.clipping import clipped
from damper_estimator.signals.possible import FASTEST
from damper_estimator.signals.rest import noise_level, quantum
from damper_estimator.validation.finding import DataFinding, entry

LEAST_LOST = 0.01  # share of samples that are missing or unusable
UNEVEN = 0.3  # standard deviation of the steps over their mean
ROUNDED = 0.05  # error of a rounded stamp over the mean step
COARSE = 0.05  # error that quantisation makes of the velocity, over its rms; or of the force
_WINDOW = 64
_LISTED = 4  # times of spikes
_AT_THE_NODE = {
    "displacement": f"The node cannot know what follows: it holds the last value if a step is above {FASTEST:g} m/s",
    "force": "The node compares its estimate with the force as it is",
}


def channel_findings(m: Measurement) -> list[DataFinding]:
    """The findings of one recording, channel by channel."""
    gauge_stamp = m.kinematics.stamp if m.gauge_stamp is None else m.gauge_stamp
    channels = {"displacement": (m.kinematics.stamp, m.raw_displacement)}
    if m.gauge.size:
        channels["force"] = (gauge_stamp, m.gauge)
    found = [*_dropped(m), *_spikes(m)]
    for role, (stamp, value) in channels.items():
        found += _gaps(m, role, stamp)
        found += _stamps(m, role, stamp)
        found += _dead(m, role, value)
        found += _repeated(m, role, stamp, value)
    found += _saturation(m)
    found += _coarse_displacement(m)
    found += _coarse_gauge(m)
    return found + list(_slow_rate(m, channels))


def _finding(m: Measurement, kind: str, sentence: str, remedy: str, share: float) -> DataFinding:
    return DataFinding(kind, sentence, remedy, m.recording, float(min(share, 1.0)))


def _dropped(m: Measurement) -> Iterator[DataFinding]:
    lost = m.counts.dropped
    if lost > LEAST_LOST * m.counts.samples:
        share = lost / m.counts.samples
        reasons = {"equal stamps": m.counts.duplicates, "older stamps": m.counts.inversions}
        reasons |= {"values that are not finite": m.counts.non_finite}
        listed = ", ".join(f"{count} {name}" for name, count in reasons.items() if count)
        yield _finding(
            m,
            "stamps",
            f"{100.0 * share:.2g} % of the displacement's samples are dropped: {listed}",
            "let the driver stamp each sample when it is taken, once; nothing in the signal map corrects it",
            share,
        )


def _spikes(m: Measurement) -> Iterator[DataFinding]:
    for role, times in m.spikes.items():
        total = m.counts.samples if role == "displacement" else m.gauge.size
        listed = ", ".join(f"{time:.2f}" for time in times[:_LISTED]) + " ..." * (len(times) > _LISTED)
        one = len(times) == 1
        yield _finding(
            m,
            "spikes",
            f"{len(times)} sample{'s' * (not one)} of the {role} leave{'s' * one} its course and come{'s' * one} back, "
            f"as nothing that moves can, at {listed} s",
            f"left out here; check plug, cable and bus. {_AT_THE_NODE[role]}",
            len(times) / max(total, 1),
        )


def _gaps(m: Measurement, role: str, stamp: np.ndarray) -> Iterator[DataFinding]:
    steps = np.diff(stamp) / 1e9
    steps = steps[steps > 0.0]
    if steps.size < 10:
        return
    period = float(np.median(steps))
    holes = steps[steps > max(DEFAULT_MAX_GAP, 1.5 * period)]
    # A window of the signal map also ends a stretch of displacement.
    if holes.size and (role == "force" or m.counts.gaps + m.counts.steps_back):
        share = float(holes.sum() / steps.sum())
        yield _finding(
            m,
            "gaps",
            f"the {role} has {holes.size} gap{'s' * (holes.size > 1)} of {holes.min():.2g} s"
            f"{f' to {holes.max():.2g} s' * (holes.size > 1)}, {100.0 * share:.2g} % of the recording",
            "they and 0.2 s after each are left out; record on a faster disk or with a larger cache",
            share,
        )
    short = steps[steps <= DEFAULT_MAX_GAP]
    missing = np.round(short / period) - 1.0
    share = float(missing.sum() / (missing.sum() + steps.size))
    if share > LEAST_LOST and short.std() <= UNEVEN * period + np.sqrt(share) * period:
        yield _finding(
            m,
            "gaps",
            f"{100.0 * share:.2g} % of the {role}'s samples are missing one by one; between them it is taken as linear",
            "raise the queue's depth or the recorder's cache; nothing in the signal map corrects it",
            share,
        )


def _stamps(m: Measurement, role: str, stamp: np.ndarray) -> Iterator[DataFinding]:
    """Stamps that are equal, rounded or jitter."""
    steps = np.diff(stamp)
    equal = float(np.mean(steps == 0)) if steps.size else 0.0
    if equal > LEAST_LOST:
        yield _finding(
            m,
            "stamps",
            f"{100.0 * equal:.2g} % of the {role}'s stamps repeat the one before",
            "let the driver stamp each sample when it is taken, with all digits",
            equal,
        )
        return
    steps = steps[(steps > 0) & (steps <= DEFAULT_MAX_GAP * 1e9)]
    if steps.size < 100:
        return
    period, whole = float(np.median(steps)), np.round(steps / 1e3).astype(np.int64)  # us
    grain = 1000 * int(np.gcd.reduce(whole))
    if grain < 1000 * np.median(whole) and grain / np.sqrt(12.0) > ROUNDED * period:
        yield _finding(
            m,
            "stamps",
            f"the {role}'s stamps are rounded to {grain / 1e6:.3g} ms at a step of {steps.mean() / 1e6:.3g} ms: its "
            f"slope is off by {100.0 * grain / np.sqrt(6.0) / steps.mean():.2g} % from sample to sample",
            "let the driver write all digits of the stamp; a lower cutoff in the signal map smooths it",
            1.0,
        )
        return
    single = steps[steps < 1.5 * period]
    if steps.std() > UNEVEN * period and np.mean(steps > 1.5 * period) > LEAST_LOST and single.std() > 0.15 * period:
        yield _finding(
            m,
            "stamps",
            f"the {role}'s stamps are uneven: steps of {np.quantile(steps, 0.05) / 1e6:.2g} to "
            f"{np.quantile(steps, 0.95) / 1e6:.2g} ms",
            "stamp the samples where they are taken, not where they arrive",
            1.0,
        )


def _dead(m: Measurement, role: str, value: np.ndarray) -> Iterator[DataFinding]:
    if value.size > 1 and np.ptp(value) == 0.0:
        channel = getattr(m.signals, role)
        yield _finding(
            m,
            "dead_channel",
            f"the {role} never changes ({value[0]:.4g} throughout)",
            f"check sensor and cable, and that topic {channel.topic}, field {channel.field} is the right one",
            1.0,
        )


def _repeated(m: Measurement, role: str, stamp: np.ndarray, value: np.ndarray) -> Iterator[DataFinding]:
    """Values repeated by a logger that is faster than the sensor."""
    change = np.diff(value)
    steps = np.abs(change[change != 0.0])
    if steps.size < 100 or value.size < 3 * steps.size / 2:
        return
    runs = np.diff(np.flatnonzero(change), prepend=-1)
    times = int(np.median(runs))
    # A coarse signal repeats itself as well, but then moves by one quantum.
    if times < 2 or np.mean(np.abs(runs - times) <= 1) < 0.6 or np.median(steps) < 4.0 * steps.min():
        return
    rate = stamp.size / max((stamp[-1] - stamp[0]) / 1e9, 1e-9)
    yield _finding(
        m,
        "held",
        f"every value of the {role} comes {times} times: the sensor delivers {rate / times:.3g} Hz, the logger writes "
        f"{rate:.3g} Hz; the held values are late by {500.0 * (times - 1) / rate:.2g} ms on average",
        f"record each value once; until then `{entry(role, m.signals, skew=round(0.5 * (times - 1) / rate, 5))}`",
        1.0,
    )


def _saturation(m: Measurement) -> Iterator[DataFinding]:
    cut = clipped(m.gauge)
    if not cut.any():
        return
    levels = np.unique(m.gauge[cut])
    at = " and ".join(f"{level:.4g} N" for level in levels)
    yield _finding(
        m,
        "saturation",
        f"the gauge clips at {at}: {np.count_nonzero(cut)} samples, {100.0 * cut.mean():.2g} % of the recording",
        "they and the filtered samples around them are left out; widen the amplifier's range",
        float(cut.mean()),
    )


def _coarse_displacement(m: Measurement) -> Iterator[DataFinding]:
    """Quantisation causes most of the noise of the model's velocity."""
    step = quantum(m.raw_displacement)
    k = m.kinematics
    speed = float(np.sqrt(np.mean(k.velocity**2)))
    if step <= 0.0 or speed <= 0.0 or m.cutoff <= 0.0 or _noise(m.raw_displacement) > 0.6 * step:
        return
    error = step * (np.random.default_rng(0).random(len(k)) - 0.5)
    x, v, a = np.empty((3, len(k)))
    differentiate(m.cutoff, np.ascontiguousarray(k.dt), error, np.zeros(STATE_SIZE), x, v, a)
    share = float(np.std(v) / speed)
    if share <= COARSE:
        return
    # The error goes with the cutoff to the power of 1.5, the motion that is lost with it not quite.
    cutoff = float(f"{max(0.85 * m.cutoff * (COARSE / share) ** (2.0 / 3.0), 5.0):.2g}")
    yield _finding(
        m,
        "quantisation",
        f"the displacement comes in steps of {1e3 * step:.3g} mm, which alone makes the velocity uncertain by "
        f"{100.0 * share:.2g} % of its rms",
        f"`filter: {{cutoff: {cutoff:g}, band: {min(m.band, cutoff):g}}}`; a finer sensor or converter",
        share,
    )


def _coarse_gauge(m: Measurement) -> Iterator[DataFinding]:
    step, spread = quantum(m.gauge), float(m.gauge.std()) if m.gauge.size else 0.0
    if step > 0.0 and step / np.sqrt(12.0) > COARSE * spread > 0.0:
        yield _finding(
            m,
            "quantisation",
            f"the gauge comes in steps of {step:.3g} N, {100.0 * step / spread:.2g} % of the force's rms",
            "set the amplifier's range to the forces that occur",
            step / np.sqrt(12.0) / spread,
        )


def _noise(value: np.ndarray) -> float:
    """Level of a window of middling quietness: quantised rest shows none, fast motion too much."""
    windows = [noise_level(value[i : i + _WINDOW]) for i in range(0, max(value.size - _WINDOW, 1), _WINDOW)]
    moving = [level for level in windows if level > 0.0]
    return float(np.quantile(moving, 0.2)) if moving else 0.0


def _slow_rate(m: Measurement, channels: dict[str, tuple[np.ndarray, np.ndarray]]) -> Iterator[DataFinding]:
    for role, limit, name in (("displacement", m.cutoff, "cutoff"), ("force", m.band, "band")):
        if role not in channels or limit <= 0.0:
            continue
        steps = np.diff(channels[role][0]) / 1e9
        steps = steps[steps <= max(DEFAULT_MAX_GAP, 1.5 * float(np.median(steps)))] if steps.size else steps
        if not steps.size or 1.0 / steps.mean() >= LEAST_RATE * limit:
            continue
        rate = 1.0 / float(steps.mean())
        cutoff, band = min(m.cutoff, 0.35 * rate), min(m.band, 0.2 * rate)
        yield _finding(
            m,
            "rate",
            f"the {role} comes at {rate:.3g} Hz, which shows nothing above {rate / 2.0:.3g} Hz, and the {name} is "
            f"{limit:g} Hz",
            f"`filter: {{cutoff: {cutoff:.2g}, band: {band:.2g}}}`, or record faster",
            1.0,
        )
        return
