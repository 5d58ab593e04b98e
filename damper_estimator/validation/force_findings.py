"""Mistakes of the force channel, found against the motion: wrong sign, wandering zero, drifting clock, a spring."""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.numerics import least_squares
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import A, V, X
from damper_estimator.signals.rest import find_rests
from damper_estimator.validation.differing_zeros import LEAST_DRIFT, zeros_differ
from damper_estimator.validation.drift import drift
from damper_estimator.validation.finding import DataFinding, entry
from damper_estimator.validation.surrogate import Surrogate, Zero, surrogate

_CERTAIN = 5.0  # standard errors
LEAST_CLOCK = 1e-3  # s, change of lateness over the recording
LEAST_SPRING = 0.3  # rms of a straight line over displacement, over the force's
_SAME_POSITION = 0.02  # of the stroke
_CONFIRMED = 0.5  # of a drift must show at rest
_BLOCKS = 8
_LEAST_BLOCK = 1.0  # s; shorter ones are not independent
_STEADY = 0.06  # scatter of the logarithm of a mean square that is the same in all blocks
_LATEST = 5e-3  # s: no damper's lateness changes by more
_UNEXPLAINED = 0.95  # rms of the force that does not follow the motion at all, over its rms


def force_findings(model: DamperModel | None, measurements: Sequence[Measurement]) -> list[DataFinding]:
    """Findings of recordings with a force, of each alone and of all compared with each other."""
    found: list[DataFinding] = []
    moved: list[tuple[Measurement, Surrogate]] = []
    for m in measurements:
        explained = surrogate([m])
        if explained is None:
            continue
        if explained.rest_n > _UNEXPLAINED * explained.rms_n:
            found.append(_no_force_finding(m))
            continue
        if wrong := list(_sign(model, m)):
            found += wrong
            continue
        found += [*_drift(m, explained), *_clock(m, explained), *_spring(m, explained)]
        moved.append((m, explained))
    return found + list(zeros_differ(moved))


def _no_force_finding(m: Measurement) -> DataFinding:
    channel = m.signals.force
    return DataFinding(
        "dead_channel",
        "the force does not follow the motion at all",
        f"check the gauge, its cable, and that topic {channel.topic}, field {channel.field} is this damper's",
        m.recording,
        1.0,
    )


def _sign(model: DamperModel | None, m: Measurement) -> Iterator[DataFinding]:
    """A damper dissipates energy: the part of the force that follows the velocity is positive."""
    k, judged = m.kinematics, m.judged
    force, v, x = m.in_band(m.force)[judged], k.velocity[judged], k.displacement[judged]
    columns = np.stack([v - v.mean(), x - x.mean()], axis=1)
    columns = columns / (columns.std(axis=0) + 1e-12)
    damping, _ = least_squares(columns, force - force.mean())[0]
    share = float(damping / force.std()) if force.std() > 0.0 else 0.0
    power = float(np.mean((force - force.mean()) * v))
    if share > -0.3 or power >= 0.0:
        return
    role = _channel_to_turn(model, m)
    lines = {name: entry(name, m.signals, **_negative(m, name)) for name in ("force", "displacement")}
    remedy = (
        f"`{lines[role]}`" if role else f"`{lines['force']}`, or `{lines['displacement']}`: push the damper together "
    )
    if not role:
        remedy += "by hand, displacement and force must both fall"
    what = role or "force or displacement"
    yield DataFinding(
        "sign",
        f"the damper seems to produce energy ({-power:.3g} W on average): {what} has the wrong sign",
        remedy,
        m.recording,
        1.0,
    )


def _negative(m: Measurement, role: str) -> dict[str, float]:
    channel = getattr(m.signals, role)
    turned = {"scale": -channel.scale} | ({"offset": -channel.offset} if channel.offset else {})
    return turned | ({"preload": -m.signals.preload} if role == "force" and m.signals.preload else {})


def _channel_to_turn(model: DamperModel | None, m: Measurement) -> str:
    """The channel whose reversal brings the model closer; "" without a model or where both do equally."""
    if model is None:
        return ""
    block = m.kinematics.block
    mirrored = block.copy()
    mirrored[[X, V, A]] *= -1.0
    judged = m.judged
    measured = m.in_band(m.force)
    errors = {}
    for role, (motion, sign) in {"force": (block, -1.0), "displacement": (mirrored, 1.0)}.items():
        modelled = model.force(motion)
        if not np.isfinite(modelled[judged]).all():
            return ""
        errors[role] = float(np.var((m.in_band(np.nan_to_num(modelled)) - sign * measured)[judged]))
    best, other = sorted(errors, key=errors.get)
    return best if errors[best] < 0.7 * errors[other] else ""


def _drift(m: Measurement, explained: Surrogate) -> Iterator[DataFinding]:
    found = drift(m, explained)
    if found is None or abs(found.change) <= max(LEAST_DRIFT * explained.rms_n, explained.rest_n):
        return
    if not _confirmed_at_rest(m, explained.zeros[0]):  # a working damper's gas and fluid may change the mean as well
        return
    begin, end, change = found.begin, found.end, found.change
    start, stop = _calmest_half(explained.zeros[0])
    warmth = _warming(m, begin, end)
    yield DataFinding(
        "zero_drift",
        f"the force at standstill drifts by {change:+.3g} N between {begin:.3g} and {end:.3g} s"
        + (f", while the temperature changes by {warmth:+.2g} K" if warmth else "")
        + ": the gauge's zero"
        + (", or gas that warms" if warmth * -change > 0.0 else ""),
        f"tare before each run and let the amplifier warm up; the calmest half is `use: [{{from: {start:.3g}, to: "
        f"{stop:.3g}}}]`",
        m.recording,
        min(abs(change) / explained.rms_n, 1.0),
    )


def _confirmed_at_rest(m: Measurement, zero: Zero) -> bool:
    """Whether the force at rest changed as the zero did, between the two rests at one position where it changed most.

    At another position gas and springs have another force.
    """
    k = m.kinematics
    rests = find_rests(k.stamp, m.raw_displacement, k.stamp, m.force)
    alike = _SAME_POSITION * float(np.ptp(m.raw_displacement))
    changes = [
        (float(np.diff(np.interp([0.5 * (one.start + one.end) for one in pair], zero.knots, zero.value))[0]),
         pair[1].force - pair[0].force)
        for pair in combinations(rests, 2) if abs(pair[1].displacement - pair[0].displacement) <= alike
    ]  # fmt: skip
    if not changes:
        return False
    expected, seen = max(changes, key=lambda pair: abs(pair[0]))
    return seen * np.sign(expected) >= _CONFIRMED * abs(expected)


def _warming(m: Measurement, begin: float, end: float) -> float:
    """Change of the temperature in K between two times; 0 where it is small or unknown."""
    k = m.kinematics
    known = np.flatnonzero(np.isfinite(k.temperature))
    if not known.size:
        return 0.0
    at = np.interp([begin, end], (k.time - k.time[0])[known], k.temperature[known])
    change = float(at[1] - at[0])
    return change if abs(change) >= 5.0 else 0.0


def _calmest_half(zero: Zero) -> tuple[float, float]:
    """The half of the recording in which the zero moves least, s."""
    half = 0.5 * float(zero.knots[-1] - zero.knots[0])
    starts = np.linspace(zero.knots[0], zero.knots[-1] - half, 9)
    fine = np.linspace(0.0, half, 50)
    ranges = [float(np.ptp(np.interp(start + fine, zero.knots, zero.value))) for start in starts]
    start = float(starts[int(np.argmin(ranges))])
    return start, start + half


def _clock(m: Measurement, explained: Surrogate) -> Iterator[DataFinding]:
    """Lateness that changes over the recording: the clocks of the two channels drift apart."""
    time = m.kinematics.time[explained.rows[0]] - m.kinematics.time[0]
    slope = np.gradient(explained.motion[0], time)
    edges = np.linspace(time[0], time[-1], _BLOCKS + 1)
    if edges[1] - edges[0] < _LEAST_BLOCK:
        return
    block = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, _BLOCKS - 1)
    weight = np.bincount(block, slope**2, _BLOCKS)
    enough = weight > 0.02 * weight.sum()
    if np.count_nonzero(enough) < 5:
        return
    late = -np.bincount(block, explained.residual[0] * slope, _BLOCKS)[enough] / weight[enough]
    middle, weight = 0.5 * (edges[1:] + edges[:-1])[enough], weight[enough] / weight[enough].sum()
    span = float(time[-1] - time[0])
    slopes = [_slope(middle, late, weight)]
    rate = slopes[0][0]
    if abs(rate) * span < _LATEST:
        slopes += [_slope(middle, late, weight, one) for one in _motions(explained, block, slope, enough)]
    if any(abs(each) * span <= LEAST_CLOCK or abs(each) <= 1.2 * _CERTAIN * error for each, error in slopes):
        return
    yield DataFinding(
        "clock_drift",
        f"the force's clock runs {abs(1e6 * rate):.2g} ppm {'slow' if rate > 0.0 else 'fast'} against the "
        f"displacement's: its lateness changes by {1e3 * rate * span:+.2g} ms over the recording",
        "stamp both channels by one clock (PTP, one converter); a skew in the signal map corrects short windows only",
        m.recording,
        1.0,
    )


def _motions(explained: Surrogate, block: np.ndarray, slope: np.ndarray, enough: np.ndarray) -> Iterator[np.ndarray]:
    """What a valve, or something in series, may be late by: logarithms of the force's size and of its frequency in
    blocks (k,), where they change.
    """
    count = np.bincount(block, minlength=_BLOCKS)[enough]
    size, fast = (np.bincount(block, one**2, _BLOCKS)[enough] for one in (explained.motion[0], slope))
    yield from (one for one in (np.log(size / count), np.log(fast / size)) if np.std(one) > _STEADY)


def _slope(
    at: np.ndarray, values: np.ndarray, weight: np.ndarray, beside: np.ndarray | None = None
) -> tuple[float, float]:
    """The slope of values (k,) over ``at`` with its standard error; with ``beside``, of what that does not explain."""
    columns = np.stack([np.ones_like(at), at, *([] if beside is None else [beside])], axis=1)
    squares = np.linalg.pinv(columns.T @ (weight[:, None] * columns))
    found = squares @ (columns.T @ (weight * values))
    scatter = values - columns @ found
    variance = float(weight @ scatter**2) / (at.size - columns.shape[1])
    return float(found[1]), float(np.sqrt(variance * squares[1, 1]))


def _spring(m: Measurement, explained: Surrogate) -> Iterator[DataFinding]:
    """The same straight line over displacement in both directions makes up much of the force."""
    k, rows = m.kinematics, explained.rows[0]
    force, v, x = m.in_band(m.force)[rows], k.velocity[rows], k.displacement[rows]
    # A damper that keeps a force between two positions shows a step where a spring shows a line.
    step = np.tanh((x - np.median(x)) / (0.3 * x.std() + 1e-9))
    columns = np.stack([v, np.sqrt(np.abs(v)), np.ones_like(v), x, step], axis=1)
    scale = np.sqrt(np.mean(columns**2, axis=0)) + 1e-12
    rates = []
    for inside in (v > 0.0, v < 0.0):
        if np.count_nonzero(inside) < 50:
            return
        rates += [
            float(least_squares(columns[inside, :count] / scale[:count], force[inside])[0][3]) for count in (4, 5)
        ]
    rates = np.array(rates) / scale[3]
    rate = float(np.mean(rates[::2]))
    share = abs(rate) * float(x.std()) / explained.rms_n
    if share < LEAST_SPRING or min(rates, key=abs) * rate <= 0.0 or min(np.abs(rates)) < 0.7 * max(np.abs(rates)):
        return
    what = "a spring seems to be in the gauge's force" if rate > 0.0 else "the spring seems to be subtracted twice"
    yield DataFinding(
        "spring",
        f"a straight line of {rate / 1e3:.3g} N/mm over displacement makes up {100.0 * share:.0f} % of the force's "
        f"rms: {what}",
        f"if so, `{entry('force', m.signals, spring_rate=round(m.signals.spring_rate + rate, -1))}`; "
        "diagnose judges it against gas and mounts",
        m.recording,
        min(share, 1.0),
    )
