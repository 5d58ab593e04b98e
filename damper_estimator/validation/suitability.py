"""Whether a recording is good enough to identify a damper, and which excitation to record next."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from scipy import signal

from damper_estimator.signals import Measurement
from damper_estimator.validation.channel_quality import ChannelQuality
from damper_estimator.validation.finding import DataFinding

CELLS = 12  # of the velocity-displacement plane, each way
LEAST_SECONDS, LEAST_RATE, LEAST_SPEED, LEAST_STROKE = 5.0, 100.0, 0.05, 0.004
LEAST_COVERAGE, LEAST_FREQUENCY_RATIO = 0.3, 2.0


@dataclass(frozen=True)
class Excitation:
    """How a damper was moved. Ranges are (low, high), without the last thousandth at each end.

    Attributes:
        seconds: recorded between resets.
        displacement, velocity, acceleration, force: m, m/s, m/s^2, N; force is None where none was measured.
        coverage: share of the cells of the velocity-displacement plane, over its ranges, that were visited.
        frequency: Hz below which 5 % and 95 % of the velocity's power lie; NaN where too short.
        damping: N s/m, slope of the force over velocity with displacement's part taken out; NaN without force.
        stiffness: N/m, slope of the force over displacement, likewise.
    """

    seconds: float
    displacement: tuple[float, float]
    velocity: tuple[float, float]
    acceleration: tuple[float, float]
    force: tuple[float, float] | None
    coverage: float
    frequency: tuple[float, float]
    damping: float
    stiffness: float

    def record(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def excitation(measurement: Measurement) -> Excitation:
    """The excitation in a measurement."""
    k = measurement.kinematics
    warm = k.warm() if k.warm().any() else np.ones(len(k), bool)
    x, v, a = k.displacement[warm], k.velocity[warm], k.acceleration[warm]
    damping = stiffness = float("nan")
    force = None
    if measurement.force is not None and measurement.judged.any():
        judged = measurement.judged
        force = _range(measurement.force[judged])
        columns = np.stack([k.velocity[judged], k.displacement[judged], np.ones(judged.sum())], axis=1)
        damping, stiffness, _ = np.linalg.lstsq(columns, measurement.force[judged], rcond=None)[0].tolist()
    return Excitation(
        seconds=float(k.dt.sum()),
        displacement=_range(x),
        velocity=_range(v),
        acceleration=_range(a),
        force=force,
        coverage=_coverage(v, x),
        frequency=_frequencies(measurement),
        damping=damping,
        stiffness=stiffness,
    )


def _range(value: np.ndarray) -> tuple[float, float]:
    low, high = np.quantile(value, [0.001, 0.999]).tolist()
    return low, high


def _coverage(v: np.ndarray, x: np.ndarray) -> float:
    if np.ptp(v) <= 0.0 or np.ptp(x) <= 0.0:
        return 0.0
    count = np.histogram2d(v, x, bins=CELLS, range=[_range(v), _range(x)])[0]
    return float(np.mean(count >= 5))


def _frequencies(measurement: Measurement) -> tuple[float, float]:
    k = measurement.kinematics
    part = max(k.stretches(), key=lambda s: s.stop - s.start)
    velocity = k.velocity[part]
    if velocity.size < 64 or not np.any(velocity):
        return float("nan"), float("nan")
    time = k.time[part]
    even = np.interp(np.arange(time[0], time[-1], 1.0 / k.rate), time, velocity)
    frequency, density = signal.welch(even, k.rate, nperseg=min(even.size, round(8.0 * k.rate)))
    share = np.cumsum(density) / density.sum()
    low, high = (float(frequency[np.searchsorted(share, level)]) for level in (0.05, 0.95))
    return low, high


@dataclass(frozen=True)
class Verdict:
    """Whether a damper can be identified, the reasons against it, and tests that would help.

    Attributes:
        good: whether there is no fault.
        faults: reasons against it, in words.
        remarks: weaknesses of the result.
        drive_next: manoeuvres or tests that would help.
    """

    good: bool
    faults: tuple[str, ...]
    remarks: tuple[str, ...]
    drive_next: tuple[str, ...]

    def record(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def verdict(
    e: Excitation,
    displacement: ChannelQuality,
    force: ChannelQuality | None,
    at_rest: bool,
    findings: Sequence[DataFinding] = (),
    misses: str = "",
) -> Verdict:
    """Judges excitation, data quality and the mistakes that were found together; ``misses`` says why the force cannot
    be compared with the motion.
    """
    faults, remarks, drive = [], [], []
    if force is None:
        faults.append("no force was measured")
    elif force.saturated > 0.001 * force.samples:
        faults.append(
            f"the gauge clips: {force.saturated} samples sit at its extremes ({force.low:.4g}, {force.high:.4g} N)"
        )
    lost = displacement.duplicates + displacement.inversions + displacement.non_finite
    if lost > 0.2 * displacement.samples:
        faults.append(
            f"{lost} of {displacement.samples} samples must be dropped (equal or older stamps, not finite): "
            "correct the stamps"
        )
    elif lost or displacement.gaps:
        remarks.append(f"{lost} samples are dropped, {displacement.gaps} gaps are left out")
    if not displacement.rate_hz >= LEAST_RATE:
        faults.append(f"{displacement.rate_hz:.4g} Hz is slow; velocity needs at least {LEAST_RATE:g} Hz")
    if e.seconds < LEAST_SECONDS:
        faults.append(f"{e.seconds:.1f} s is short")
        drive.append("record half a minute or more")
    _judge_motion(e, displacement, faults, remarks, drive)
    faults += [misses] if misses else []
    spoiling = [finding for finding in findings if finding.spoils]
    faults += [finding.sentence for finding in spoiling]
    if np.isfinite(e.damping) and e.damping <= 0.0 and not spoiling:
        faults.append("the force opposes the wrong direction (it falls with velocity): turn a sign in the signal map")
    if not at_rest:
        remarks.append("no rest: offsets cannot be zeroed")
        drive.append("stand still for two seconds at the beginning, for tare")
    return Verdict(not faults, tuple(faults), tuple(remarks), tuple(drive))


def _judge_motion(e: Excitation, displacement: ChannelQuality, faults: list, remarks: list, drive: list) -> None:
    speed, stroke = min(-e.velocity[0], e.velocity[1]), e.displacement[1] - e.displacement[0]
    if speed < LEAST_SPEED:
        faults.append(f"speeds stay below {speed:.2g} m/s in one direction or both: the valves are hardly seen")
        drive.append("drive faster over bumps (or a dyno at 0.1 to 1 m/s), so that both directions reach 0.3 m/s")
    elif speed < 0.3:
        remarks.append(
            f"speeds reach {-e.velocity[0]:.2g} m/s in compression and {e.velocity[1]:.2g} m/s in rebound; "
            "nothing is known above that"
        )
        drive.append("faster strokes, to see the valves open")
    if stroke < LEAST_STROKE:
        faults.append(f"the stroke is only {1e3 * stroke:.2g} mm")
        drive.append("larger strokes: waves, kerbs, or a sine of 10 mm and more")
    if displacement.quantum > 0.01 * stroke:
        remarks.append(
            f"displacement is coarse: {1e3 * displacement.quantum:.3g} mm steps in {1e3 * stroke:.3g} mm of stroke"
        )
    low, high = e.frequency
    if np.isfinite(low) and high < LEAST_FREQUENCY_RATIO * max(low, 1e-9):
        remarks.append(
            f"one frequency only ({low:.2g} to {high:.2g} Hz): dependence on frequency cannot be distinguished "
            "from dependence on speed"
        )
        drive.append("other frequencies at the same speed, or random excitation")
    if e.coverage < LEAST_COVERAGE:
        remarks.append(
            f"{100 * e.coverage:.0f} % of the velocity-displacement plane is covered: position and speed are "
            "hard to separate"
        )
        drive.append("strokes of other amplitude, and about other mean positions")
