"""Figures over records, each with its 90 % interval."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

Record = dict[str, Any]
Z = 1.6449  # 90 %, both sides
SKEW_MARGIN = 3e-4  # s
AS_GOOD = 1.05  # times an error: no worse


def groups(record: Record) -> list[set[str]]:
    """The tied group of every finding."""
    return [{one["phenomenon"], *one["tied_with"]} for one in record["findings"]]


def named(record: Record) -> str:
    """The phenomenon of the first finding; the verdict without findings."""
    return record["findings"][0]["phenomenon"] if record["findings"] else record["verdict"]


def first(record: Record) -> bool:
    """Whether a hidden effect is the first finding."""
    return named(record) in record["hidden"]


def tied(record: Record) -> bool:
    """Whether a hidden effect is in the first tied group."""
    return bool(groups(record)) and bool(groups(record)[0] & set(record["hidden"]))


def renamed(record: Record) -> bool:
    """Whether another effect is named instead of the hidden one."""
    return bool(record["findings"]) and not tied(record)


def alarm(record: Record) -> bool:
    """Whether any effect or fault is reported."""
    return record["verdict"] != "nothing_missing"


def explained(record: Record) -> bool:
    """Whether what is reported removes most of the squared error on unseen recordings: then the model lacks it, also
    where nothing was hidden.
    """
    return record["found_error"] ** 2 < 0.5 * record["before"] ** 2


def both(record: Record) -> bool:
    """Whether both hidden effects are named by different findings."""
    one, other = record["hidden"]
    named = groups(record)
    return any(one in a and other in b for i, a in enumerate(named) for j, b in enumerate(named) if i != j)


def both_added(record: Record) -> bool:
    """Whether ``improve`` added, or corrected, both."""
    pruned = {effect for action, effect, _ in record["steps"] if action == "prune"}
    put = {what for action, effect, what in record["steps"] if what and action != "prune" and effect not in pruned}
    return set(record["hidden"]) <= put


def skew_found(record: Record) -> bool:
    """Whether a hidden skew is right within 0.3 ms, or tied with an equally good explanation."""
    if not record["findings"] or "channel_skew" not in groups(record)[0]:
        return False
    return len(groups(record)[0]) > 1 or abs(record["skew"] - record["true_skew"]) <= SKEW_MARGIN


def removed(record: Record) -> float:
    """Share of the excess squared error that ``improve`` removed; NaN without excess."""
    excess = record["before"] ** 2 - record["base"] ** 2
    return (record["before"] ** 2 - record["after"] ** 2) / excess if excess > 0.0 else float("nan")


def rough(record: Record) -> bool:
    """Whether the error of the user's model without the effect exceeds the effect's change of the force.

    Such a model lacks another effect more, which is rightly the first finding.
    """
    if not record["hidden"] or record["kind"] == "real":
        return False
    # Two effects that act against each other change the force by less than either.
    return record["base"] > max(record["shown"], *record["strengths"]) * record["force_rms"]


def restored(record: Record) -> bool:
    """Whether a model without one of its effects is as good as the whole one with what was found instead."""
    return bool(record["findings"]) and record["found_error"] <= AS_GOOD * record["base"]


def unbiased(record: Record) -> bool:
    """Whether the improved model's mean error on another recording is below 2 % of the force."""
    return abs(record["bias"]) <= 0.02 * record["force_rms"]


def wilson(hits: int, count: int) -> tuple[float, float]:
    """90 % interval of a share after Wilson 1927."""
    if not count:
        return 0.0, 1.0
    share, square = hits / count, Z * Z / count
    middle = (share + 0.5 * square) / (1.0 + square)
    half = Z * np.sqrt(share * (1.0 - share) / count + 0.25 * square / count) / (1.0 + square)
    return max(middle - half, 0.0), min(middle + half, 1.0)


def bootstrap(
    values: Sequence[float], figure: Callable[[np.ndarray], float], draws: int = 2000
) -> tuple[float, float, float]:
    """A figure and its 90 % interval; NaN without finite values."""
    finite = np.array([value for value in values if np.isfinite(value)])
    if not finite.size:
        return float("nan"), float("nan"), float("nan")
    picked = np.random.default_rng(0).integers(0, finite.size, (draws, finite.size))
    low, high = np.quantile([figure(finite[sample]) for sample in picked], [0.05, 0.95])
    return float(figure(finite)), float(low), float(high)


def confidences(records: Sequence[Record]) -> tuple[np.ndarray, np.ndarray]:
    """Confidence of every first finding, and whether the hidden effect was in its group: each (n,)."""
    named_ones = [one for one in records if one["findings"]]
    return (
        np.array([one["findings"][0]["confidence"] for one in named_ones]),
        np.array([tied(one) for one in named_ones], dtype=float),
    )


def calibration(records: Sequence[Record], bins: int = 5) -> tuple[list[tuple[float, float, int]], float]:
    """Reliability (mean confidence, share right, count by bin of equal width) and expected calibration error."""
    confidence, right = confidences(records)
    at = np.minimum((confidence * bins).astype(int), bins - 1)
    rows = [
        (float(confidence[at == k].mean()), float(right[at == k].mean()), int((at == k).sum()))
        for k in range(bins)
        if (at == k).any()
    ]
    total = sum(count for *_, count in rows)
    gap = sum(count * abs(mean - share) for mean, share, count in rows) / total if total else float("nan")
    return rows, gap
