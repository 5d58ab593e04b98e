"""What of a long signal is drawn, and which samples lie in a mark that was drawn by hand."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.report import min_max_rows

LINE_POINTS = 2400  # about two per pixel
CLOUD_SAMPLES = 20_000  # that are looked at
CLOUD_CELLS = (36, 26)  # across and up, about five pixels wide
_DENSE = (0.5, 0.85)  # shares of the cells, by how full they are, from which on the cloud is darker


def line_rows(values: np.ndarray, most: int = LINE_POINTS) -> np.ndarray:
    """Rising indices of about ``most`` samples (n,) and both ends; see ``min_max_rows``."""
    return min_max_rows([values], most + 2)


def cloud_rows(over: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Rising indices of samples (n,) for a cloud: one in each cell of a grid that any is in, and the extremes of both.

    A browser draws a cloud in proportion to its points, so points that would lie over each other are left out.
    """
    return np.unique(np.concatenate(density_rows(over, force)))


def density_rows(over: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, ...]:
    """The same in three parts, by how many samples are in the cell: few with the extremes, some, and most."""
    even = np.arange(0, over.size, max(-(-over.size // CLOUD_SAMPLES), 1))
    even = even[np.isfinite(over[even]) & np.isfinite(force[even])]
    across, up = (_cells(values[even], cells) for values, cells in zip((over, force), CLOUD_CELLS, strict=True))
    _, first, counts = np.unique(across * CLOUD_CELLS[1] + up, return_index=True, return_counts=True)
    extremes = np.concatenate([line_rows(values, 2) for values in (over, force)])
    extremes = extremes[np.isfinite(over[extremes]) & np.isfinite(force[extremes])]
    limits = np.quantile(counts, _DENSE) if counts.size else np.zeros(len(_DENSE))
    level = np.searchsorted(limits, counts)
    parts = [even[first[level == density]] for density in range(len(_DENSE) + 1)]
    return np.unique(np.concatenate([parts[0], extremes])), *parts[1:]


def _cells(values: np.ndarray, cells: int) -> np.ndarray:
    """(n,) int: the cell of each value between the smallest and the largest."""
    low, span = (values.min(), np.ptp(values)) if values.size else (0.0, 0.0)
    return ((values - low) * ((cells - 1) / max(span, 1e-300))).astype(np.int64)


def span_of(time: np.ndarray, start: float | None, stop: float | None) -> slice:
    """The samples between two times in s, with one neighbour at either side; all where no times are given."""
    if start is None or stop is None:
        return slice(0, time.size)
    first, last = np.searchsorted(time, [start, stop])
    first = min(max(int(first) - 1, 0), time.size - 1)
    return slice(first, max(min(int(last) + 1, time.size), first + 1))


@dataclass(frozen=True)
class Mark:
    """What was marked by hand in one of the figures.

    Attributes:
        figure: ``time``, or the motion that the force was drawn over.
        x, y: corners of a polygon in the figure's units; for ``time`` only x counts.
    """

    figure: str
    x: tuple[float, ...]
    y: tuple[float, ...] = ()

    def inside(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(n,) bool: which points (n,), (n,) lie in it."""
        within = (x >= min(self.x)) & (x <= max(self.x))
        if self.figure == "time":
            return within
        within &= (y >= min(self.y)) & (y <= max(self.y))
        rows = np.flatnonzero(within)
        within[rows] = _in_polygon(x[rows], y[rows], self.x, self.y)
        return within


def _in_polygon(x: np.ndarray, y: np.ndarray, corners_x: Sequence[float], corners_y: Sequence[float]) -> np.ndarray:
    """(n,) bool by the number of edges that a ray to the right crosses."""
    odd = np.zeros(x.size, bool)
    before_x, before_y = corners_x[-1], corners_y[-1]
    for next_x, next_y in zip(corners_x, corners_y, strict=True):
        if next_y != before_y:
            crosses = (before_y > y) != (next_y > y)
            odd ^= crosses & (x < before_x + (y - before_y) * (next_x - before_x) / (next_y - before_y))
        before_x, before_y = next_x, next_y
    return odd
