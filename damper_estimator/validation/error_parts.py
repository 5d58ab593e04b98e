"""The parts of an error: the gauge's zero, its drift, a gain, and scatter.

    e = zero + drift(t) + gain F_model + rest

The drift is determined from whole cycles of the motion (``surrogate`` of the error), the zero from slow motion, where
it is the same in both directions, at every piston position and all the time. An error in one direction, at one position
or at one speed is neither. Both are removed before the search for regions because they do not depend on the operation.
Parts that are small compared with the rest, or within chance, are neither reported nor removed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper_estimator.numbers import number
from damper_estimator.validation.drift import Drift, drift
from damper_estimator.validation.surrogate import surrogate
from damper_estimator.validation.trace import Trace

LEAST_SHARE = 0.05  # of the squared error
_GAIN_SHARE = 0.5  # of the squared error without zero and drift, above which a gain is reported
_ALIKE = 0.4  # by which the gain of any direction and size may differ from the whole
_REST, _SLOWEST = 0.01, 0.15  # of the largest speed, above which the damper moves; share of motion that is slow
_NAMED = 3  # recordings whose zeros are listed one by one


@dataclass(frozen=True)
class ErrorParts:
    """The parts of an error.

    Attributes:
        offsets: N, per recording: error at standstill; 0 where it is not reported.
        slow: per recording (n,) N, offset and drift together, 0 where not reported.
        offset_n: N, mean of all recordings weighted by their samples.
        drift_n: N rms.
        gain: 1, (F_model - F) / F that fits the rest best; positive where the model's force is too large.
        gain_n: N rms of that.
        scatter_n: N rms of the remainder.
        sentences: the reported parts, in words.
    """

    offsets: tuple[float, ...]
    slow: tuple[np.ndarray, ...]
    offset_n: float
    drift_n: float
    gain: float
    gain_n: float
    scatter_n: float
    sentences: tuple[str, ...]

    def record(self) -> dict[str, object]:
        """For JSON."""
        names = ("offset_n", "drift_n", "gain", "gain_n", "scatter_n", "sentences")
        return {name: getattr(self, name) for name in names}


def error_parts(traces: Sequence[Trace]) -> ErrorParts:
    """Splits the error of a model over recordings into its parts."""
    judged = [t.judged for t in traces]
    error = _pooled([t.residual for t in traces], judged)
    total = float(np.mean(error**2))
    least = float(np.sqrt(LEAST_SHARE * total))
    drifts, words = [np.zeros(t.time.size) for t in traces], []
    explained = surrogate([t.measurement for t in traces], [t.residual for t in traces]) if total > 0.0 else None
    for i, (t, zero) in enumerate(zip(traces, explained.zeros if explained else (), strict=False)):
        if zero is None:
            continue
        line = zero.line(t.time, t.judged)
        if np.mean(line[t.judged] ** 2) > LEAST_SHARE * total and (found := drift(t.measurement, explained, i)):
            drifts[i] = line
            words.append(_drift_in_words(t, len(traces), found))
    offsets = [_offset(t, t.residual - line, least) for t, line in zip(traces, drifts, strict=True)]
    words = _zero_in_words(traces, offsets) + words
    slow = [offset + line for offset, line in zip(offsets, drifts, strict=True)]
    rest = error - _pooled(slow, judged)
    modelled = _pooled([t.modelled for t in traces], judged)
    share, along = _gain(rest, modelled)
    if np.mean(along**2) > _GAIN_SHARE * max(float(np.mean(rest**2)), 1e-300) and _is_gain(rest, modelled, share):
        words.append(_gain_in_words(share, float(np.mean(along**2) / np.mean(rest**2))))
    else:
        velocity = np.concatenate(
            [t.measurement.kinematics.velocity[mask] for t, mask in zip(traces, judged, strict=True)]
        )
        words += _side_in_words(rest, velocity)
    return ErrorParts(
        offsets=tuple(offsets),
        slow=tuple(slow),
        offset_n=float(np.average(offsets, weights=[mask.sum() for mask in judged])),
        drift_n=float(np.sqrt(np.mean(_pooled(drifts, judged) ** 2))),
        gain=share / (1.0 - share) if share < 1.0 else float("inf"),
        gain_n=float(np.sqrt(np.mean(along**2))),
        scatter_n=float(np.sqrt(np.mean((rest - along) ** 2))),
        sentences=tuple(words),
    )


def _offset(trace: Trace, error: np.ndarray, least: float) -> float:
    """N, the mean of an error (n,) in slow motion; 0 where it is below ``least``, not the same everywhere, or where
    the whole error is larger without it.

    Cells are thirds of the stroke and halves of the time; the mean of both directions in each leaves no friction.
    """
    k, judged = trace.measurement.kinematics, trace.judged
    error, v, x, time = (values[judged] for values in (error, k.velocity, k.displacement, k.time))
    speed = np.abs(v)
    moving = speed > _REST * np.quantile(speed, 0.99)
    if np.count_nonzero(moving) < 100:
        return 0.0
    slow = moving & (speed <= np.quantile(speed[moving], _SLOWEST))
    places = np.searchsorted(np.quantile(x[slow], [1 / 3, 2 / 3]), x[slow]) + 3 * (time[slow] > np.median(time[slow]))
    slower = speed[slow] <= np.median(speed[slow])
    cells = []
    for place in range(6):
        there = places == place
        layers = [
            [error[slow][there & layer & direction] for direction in (v[slow] > 0.0, v[slow] < 0.0)]
            for layer in (slower, ~slower)
        ]
        if min(part.size for layer in layers for part in layer) >= 5:
            first, second = (0.5 * float(layer[0].mean() + layer[1].mean()) for layer in layers)
            # Mean speeds are about one and three: an error that grows with speed in both directions is no zero.
            cells.append(1.5 * first - 0.5 * second)
    if len(cells) < 4:
        return 0.0
    offset = float(np.median(cells))
    alike = np.abs(np.array(cells) - offset) <= 0.5 * abs(offset)
    lowers = abs(error.mean() - offset) < abs(error.mean())  # otherwise fast motion has the opposite error
    return offset if abs(offset) > least and lowers and np.count_nonzero(~alike) <= 1 else 0.0


def _gain(rest: np.ndarray, modelled: np.ndarray) -> tuple[float, np.ndarray]:
    # A sum of products: a library that starts threads for a dot product of this size takes longer to wake them.
    share = float(np.sum(rest * modelled)) / max(float(np.sum(modelled**2)), 1e-300)
    return share, share * modelled


def _is_gain(rest: np.ndarray, modelled: np.ndarray, share: float) -> bool:
    """Whether the gain is the same in both directions, and for small and large forces."""
    large = np.abs(modelled) > np.median(np.abs(modelled))
    groups = [direction & size for direction in (modelled > 0.0, modelled < 0.0) for size in (large, ~large)]
    return all(
        abs(_gain(rest[group], modelled[group])[0] - share) <= _ALIKE * abs(share)
        for group in groups
        if group.sum() > 50
    )


def _pooled(parts: Sequence[np.ndarray], judged: Sequence[np.ndarray]) -> np.ndarray:
    return np.concatenate([part[mask] for part, mask in zip(parts, judged, strict=True)])


def _zero_in_words(traces: Sequence[Trace], offsets: Sequence[float]) -> list[str]:
    zeros = {Path(t.measurement.recording).name: -o for t, o in zip(traces, offsets, strict=True) if o}
    if not zeros:
        return []
    cause = "throughout, at standstill as well: the gauge's zero, or a static force that the model lacks"
    if len(traces) == 1:
        return [f"the measured force is {_high(*zeros.values())} {cause}"]
    if len(zeros) <= _NAMED:
        return [f"the measured force is {', '.join(f'{_high(o)} in {n}' for n, o in zeros.items())}, {cause}"]
    ends = sorted(zeros, key=zeros.get)
    span = f"from {_high(zeros[ends[0]])} in {ends[0]} to {_high(zeros[ends[-1]])} in {ends[-1]}"
    return [f"the measured force is off by a constant in {len(zeros)} recordings, {span}, {cause}"]


def _side_in_words(rest: np.ndarray, velocity: np.ndarray) -> list[str]:
    """Reports an error that opposes or supports every motion equally, early and late."""
    speed = np.abs(velocity)
    edges = np.quantile(speed, [0.25, 0.5, 0.75])
    band = np.searchsorted(edges, speed)
    along = rest * np.sign(velocity)
    late = np.arange(rest.size) > rest.size // 2
    cells = [
        (band == i) & direction & half
        for i in (1, 2, 3)
        for direction in (velocity > 0.0, velocity < 0.0)
        for half in (late, ~late)
    ]
    means = [float(along[cell].mean()) for cell in cells if cell.any()] or [0.0]
    middle = float(np.median(means))
    if middle**2 < _GAIN_SHARE * float(np.mean(rest**2)) or np.ptp(means) > abs(middle):
        return []
    return [
        f"the model is {number(abs(middle))} N too {'stiff' if middle > 0.0 else 'soft'} both ways, whatever the speed"
    ]


def _high(offset: float) -> str:
    return f"{number(abs(offset))} N {'high' if offset > 0.0 else 'low'}"


def _drift_in_words(trace: Trace, count: int, found: Drift) -> str:
    where = f" in {Path(trace.measurement.recording).name}" if count > 1 else ""
    return (
        f"the measured force drifts against the model's by {-found.change:+.3g} N between {found.begin:.3g} and "
        f"{found.end:.3g} s{where}, whatever the motion"
    )


def _gain_in_words(share: float, part: float) -> str:
    size = 100.0 * abs(share / (1.0 - share)) if share < 1.0 else np.inf
    return (
        f"the model's force is {size:.2g} % too {'large' if share > 0.0 else 'small'} as a whole: that alone is "
        f"{100.0 * part:.0f} % of the squared error without zero and drift"
    )
