"""Finds dampers that drift away from their model, and the time at which it began.

For every vehicle and damper the logarithm of the relative error (rms error over rms force) of its recordings, in order
of time, minus the part that temperature and rms force explain over the whole fleet, is compared with a bend:

    y(t) = level + slope max(0, t - since),    slope > 0

``since`` is the time of the recording that fits best. The probability of a chance result comes from 9999 random orders
of the recordings, each with its own best bend; over all dampers the share of false alarms among those reported is
limited to 5 % (Benjamini and Hochberg 1995). Recordings count as independent: a seasonal change that shows neither in
the temperature nor in the force can look like a drift.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

RULE = (
    "relative error (rms error over rms force) that rises from some time on, minus the part that temperature and rms "
    "force explain over all dampers; compared with 9999 random orders of the recordings; on average at most 5 % of the "
    "dampers listed are false alarms; a damper needs 8 recordings"
)
FEWEST = 8  # recordings of a damper that are required for a judgement
FALSE_ALARMS = 0.05
ORDERS = 9999
_LEFT = 3  # recordings after the bend, at least
_DRAWN = 1000  # orders at a time
_ENOUGH = 100  # random orders that fit as well; drawing stops there


@dataclass(frozen=True)
class Trend:
    """A damper that drifts.

    Attributes:
        since_ns: time at which the error begins to rise; ``low_ns`` to ``high_ns`` is its 95 % interval.
        growth: relative error at the end over that before the bend.
        p: probability of such a bend by chance.
    """

    vehicle: str
    damper: str
    recordings: int
    since_ns: int
    low_ns: int
    high_ns: int
    growth: float
    p: float


def drifting(rows: Iterable[Mapping[str, object]]) -> tuple[list[Trend], int]:
    """The dampers that drift, most certain first, and the number that could be judged.

    Args:
        rows: of ``compare``, with ``vehicle``, ``damper``, ``begin`` (ns), ``nrmse``, ``temperature_c``,
            ``force_rms_n``; in any order.
    """
    groups: dict[tuple[str, str], list[Mapping]] = {}
    for row in rows:
        if row["begin"] is not None and row["nrmse"]:
            groups.setdefault((row["vehicle"], row["damper"]), []).append(row)
    judged = {key: sorted(group, key=_order) for key, group in sorted(groups.items()) if len(group) >= FEWEST}
    judged = {key: group for key, group in judged.items() if group[0]["begin"] < group[-1 - _LEFT]["begin"]}
    errors = _adjusted([[_features(row) for row in group] for group in judged.values()])
    found = [
        _bend(*key, np.array([row["begin"] for row in group], np.int64), error)
        for (key, group), error in zip(judged.items(), errors, strict=True)
    ]
    found.sort(key=lambda trend: trend.p)
    within = [i for i, trend in enumerate(found, 1) if trend.p <= FALSE_ALARMS * i / len(found)]
    return found[: max(within, default=0)], len(found)


def _order(row: Mapping) -> tuple[int, str]:
    return row["begin"], row["recording"]


def _features(row: Mapping) -> list[float]:
    temperature, force = row["temperature_c"], row["force_rms_n"]
    return [np.log(row["nrmse"]), np.nan if temperature is None else temperature, np.log(force) if force else np.nan]


def _adjusted(groups: Sequence[list[list[float]]]) -> list[np.ndarray]:
    """For each damper y (n,) about its mean, minus the part that the other features (n, 2) explain over all dampers."""
    centred = [np.array(group) - np.nanmean(np.array(group), axis=0, keepdims=True) for group in _known(groups)]
    if not centred:
        return []
    together = np.concatenate(centred)
    slopes = np.linalg.lstsq(together[:, 1:], together[:, 0], rcond=1e-6)[0]
    return [group[:, 0] - group[:, 1:] @ slopes for group in centred]


def _known(groups: Sequence[list[list[float]]]) -> Iterable[np.ndarray]:
    """Unknown features become the mean of the damper's known ones, which explains nothing."""
    for group in groups:
        table = np.array(group)
        for column in table.T[1:]:
            finite = np.isfinite(column)
            column[~finite] = column[finite].mean() if finite.any() else 0.0
        yield table


def _bend(vehicle: str, damper: str, stamp: np.ndarray, error: np.ndarray) -> Trend:
    time = (stamp - stamp[0]) / float(stamp[-1] - stamp[0])
    places = np.flatnonzero(np.concatenate([[True], np.diff(time[:-_LEFT]) > 0.0]))
    rising = np.maximum(0.0, time[:, None] - time[places])
    shape = rising - rising.mean(axis=0)
    length = np.linalg.norm(shape, axis=0)
    total = float(np.linalg.norm(error)) or 1.0
    correlation = (shape / length).T @ (error / total)
    best = int(np.argmax(correlation))
    left = 1.0 - np.maximum(correlation, 0.0) ** 2
    free = max(error.size - 3, 1)
    near = places[left <= left[best] * (1.0 + f_distribution.ppf(0.95, 1, free) / free)]
    slope = float(correlation[best]) * total / length[best]
    return Trend(
        vehicle=vehicle,
        damper=damper,
        recordings=int(error.size),
        since_ns=int(stamp[places[best]]),
        low_ns=int(stamp[near[0]]),
        high_ns=int(stamp[near[-1]]),
        growth=float(np.exp(slope * (1.0 - time[places[best]]))),
        p=_chance(shape / length, error / total, float(correlation[best])),
    )


def _chance(shapes: np.ndarray, error: np.ndarray, correlation: float) -> float:
    """Share of random orders of ``error`` (n,) that some shape (n, k) fits as well.

    Drawing stops early when the result is clearly chance (Besag and Clifford 1991).
    """
    draw = np.random.default_rng(0)
    better = 0
    for first in range(0, ORDERS, _DRAWN):
        orders = draw.permuted(np.tile(error, (min(_DRAWN, ORDERS - first), 1)), axis=1)
        better += int(np.count_nonzero((orders @ shapes).max(axis=1) >= correlation - 1e-12))
        if better >= _ENOUGH:
            return better / (first + len(orders))
    return (1 + better) / (1 + ORDERS)
