"""What of a long signal is drawn, and which samples lie in a mark that was drawn by hand."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from tsdownsample import MinMaxDownsampler

LINE_POINTS = 2400  # about two per pixel
CLOUD_POINTS = 1000
_THINNER = MinMaxDownsampler()


def line_rows(values: np.ndarray, span: slice, most: int = LINE_POINTS) -> np.ndarray:
    """Rising indices of at most ``most`` samples of a span; smallest and largest value of each bucket are among them.

    Args:
        values: (n,), NaN counts as no value.
        span: of the samples that are on view.
    """
    part = np.ascontiguousarray(values[span])
    if part.size <= most:
        return np.arange(span.start, span.stop)
    rows = _THINNER.downsample(part, n_out=most - most % 2).astype(np.int64)
    return span.start + np.unique(np.concatenate([[0], rows, [part.size - 1]]))


def cloud_rows(over: np.ndarray, force: np.ndarray, span: slice, most: int = CLOUD_POINTS) -> np.ndarray:
    """Rising indices of samples of a span for a cloud: evenly spread in time, and the extremes of both quantities."""
    size = span.stop - span.start
    if size <= most:
        return np.arange(span.start, span.stop)
    even = np.arange(span.start, span.stop, -(-2 * size // most))
    return np.unique(np.concatenate([even, line_rows(over, span, most // 4), line_rows(force, span, most // 4)]))


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
