"""Which dampers drift away from their model, and since when.

For every vehicle and damper the logarithm of the relative error (rms error over rms force) of its recordings, in order
of time, less what temperature and rms force explain of it over the whole fleet, is held against a bend:

    y(t) = level + slope max(0, t - since),    slope > 0

``since`` is the time of the recording that fits best. How often chance does as well is found by putting the recordings
into 9999 random orders, each with its own best bend; over all dampers the share of false alarms among those that are
named is held at 5 % (Benjamini and Hochberg 1995). Recordings count as independent of each other: a season that is
neither in the temperature nor in the force can look like a drift.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

RULE = (
    "relative error (rms error over rms force) that rises from one time on, less what temperature and rms force "
    "explain of it over all dampers; held against 9999 random orders of the recordings; on average at most 5 % of "
    "those named are false alarms; a damper needs 8 recordings"
)
FEWEST = 8  # recordings of a damper, below which nothing is said
FALSE_ALARMS = 0.05
ORDERS = 9999
_LEFT = 3  # recordings after the bend, at least
_DRAWN = 1000  # orders at a time
_ENOUGH = 100  # orders that fit as well, after which no more are drawn


@dataclass(frozen=True)
class Trend:
    """A damper that drifts away.

    Attributes:
        since_ns: where the error begins to rise; ``low_ns`` to ``high_ns`` fit nearly as well (95 %).
        growth: relative error at the end over that before.
        p: probability that chance makes such a bend of these recordings.
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
    """The dampers that drift away, the surest first, and how many could be judged.

    Args:
        rows: of ``compare``, with ``vehicle``, ``damper``, ``begin`` (ns), ``nrmse``, ``temperature_c``,
            ``force_rms_n``; in any order.
    """
    groups: dict[tuple[str, str], list[Mapping]] = {}
    for row in rows:
        if row["begin"] is not None and row["nrmse"]:
            groups.setdefault((row["vehicle"], row["damper"]), []).append(row)
    judged = {key: sorted(own, key=_when) for key, own in sorted(groups.items()) if len(own) >= FEWEST}
    judged = {key: own for key, own in judged.items() if own[0]["begin"] < own[-1 - _LEFT]["begin"]}
    errors = _adjusted([[_features(row) for row in own] for own in judged.values()])
    found = [
        _bend(*key, np.array([row["begin"] for row in own], np.int64), error)
        for (key, own), error in zip(judged.items(), errors, strict=True)
    ]
    found.sort(key=lambda trend: trend.p)
    within = [i for i, own in enumerate(found, 1) if own.p <= FALSE_ALARMS * i / len(found)]
    return found[: max(within, default=0)], len(found)


def _when(row: Mapping) -> tuple[int, str]:
    return row["begin"], row["recording"]


def _features(row: Mapping) -> list[float]:
    warm, force = row["temperature_c"], row["force_rms_n"]
    return [np.log(row["nrmse"]), np.nan if warm is None else warm, np.log(force) if force else np.nan]


def _adjusted(groups: Sequence[list[list[float]]]) -> list[np.ndarray]:
    """For each damper y (n,) about its mean, less what the other features (n, 2) explain over all dampers."""
    centred = [np.array(own) - np.nanmean(np.array(own), axis=0, keepdims=True) for own in _known(groups)]
    if not centred:
        return []
    together = np.concatenate(centred)
    slopes = np.linalg.lstsq(together[:, 1:], together[:, 0], rcond=1e-6)[0]
    return [own[:, 0] - own[:, 1:] @ slopes for own in centred]


def _known(groups: Sequence[list[list[float]]]) -> Iterable[np.ndarray]:
    """Features that are not known are the mean of the damper's others, which explains nothing."""
    for own in groups:
        table = np.array(own)
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
    told = (shape / length).T @ (error / total)
    best = int(np.argmax(told))
    left = 1.0 - np.maximum(told, 0.0) ** 2
    free = max(error.size - 3, 1)
    near = places[left <= left[best] * (1.0 + f_distribution.ppf(0.95, 1, free) / free)]
    slope = float(told[best]) * total / length[best]
    return Trend(
        vehicle=vehicle,
        damper=damper,
        recordings=int(error.size),
        since_ns=int(stamp[places[best]]),
        low_ns=int(stamp[near[0]]),
        high_ns=int(stamp[near[-1]]),
        growth=float(np.exp(slope * (1.0 - time[places[best]]))),
        p=_chance(shape / length, error / total, float(told[best])),
    )


def _chance(shapes: np.ndarray, error: np.ndarray, told: float) -> float:
    """Share of random orders of ``error`` (n,) that some shape (n, k) fits as well.

    What is clearly chance needs no more orders (Besag and Clifford 1991).
    """
    draw = np.random.default_rng(0)
    better = 0
    for first in range(0, ORDERS, _DRAWN):
        orders = draw.permuted(np.tile(error, (min(_DRAWN, ORDERS - first), 1)), axis=1)
        better += int(np.count_nonzero((orders @ shapes).max(axis=1) >= told - 1e-12))
        if better >= _ENOUGH:
            return better / (first + len(orders))
    return (1 + better) / (1 + ORDERS)
