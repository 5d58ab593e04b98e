"""Whether the error against the gauge grows, and with which quantity. Independent of ROS.

The error of a window is rms(model - measured) / rms(measured). The reference is the median of the first windows in
which the damper worked. The alarm is raised when the median of the last windows is ``factor`` times as large, and at
least two percentage points more; it is withdrawn below four fifths of that. The error grows with the quantity
(temperature, speed, stroke, offset of the gauge) whose windows rank like those of the error (Spearman's coefficient,
equal values with their mean rank); a quantity that hardly varies is not named.
"""

from dataclasses import dataclass, field

import numpy as np

from damper_estimator.numerics import rank_correlation

REFERENCE, RECENT = 3, 3  # windows
_LEAST_GROWTH = 0.02
_RELEASE = 0.8
_LEAST_SPEED = 0.01  # m/s rms; a standing damper shows no error
_MOST_WINDOWS = 600
_RELATED = 0.7  # rank correlation
_LEAST_RELATED = 6  # windows
# A quantity varies where the highest and the lowest tenth of its windows differ by more than this.
_LEAST_WARMING = 2.0  # deg C
_LEAST_VARIATION = 0.05  # of the median speed or stroke
QUANTITIES = ("temperature", "speed", "stroke", "offset")


@dataclass
class _OpenWindow:
    """Sums over one window."""

    start: float = float("nan")
    count: int = 0
    sums: np.ndarray = field(default_factory=lambda: np.zeros(8))


@dataclass(frozen=True)
class WindowError:
    """The error of one damper in one window, and the quantities by ``QUANTITIES``."""

    end: float
    error: float
    rms_n: float
    quantities: tuple[float, ...]


class Drift:
    """The running error of one damper; final.

    Attributes:
        name: of the damper.
        windows: the last ones in which it worked.
        rms_n: N, rms residual of the last window; NaN before.
        is_alarm: whether the error has grown.
    """

    def __init__(self, name: str, window: float, factor: float) -> None:
        """``window`` in s of the input's stamps; ``factor`` of growth that raises the alarm."""
        self.name = name
        self.windows: list[WindowError] = []
        self.rms_n = float("nan")
        self.is_alarm = False
        self._window, self._factor = window, factor
        self._reference: list[WindowError] = []
        self._open = _OpenWindow()

    def add(
        self,
        stamp: np.ndarray,
        residual: np.ndarray,
        measured: np.ndarray,
        velocity: np.ndarray,
        displacement: np.ndarray,
        temperature: float,
    ) -> None:
        """Takes judged samples in order of time: stamps (n,) ns, residual and measured force (n,) N, motion (n,) SI."""
        good = np.isfinite(residual) & np.isfinite(measured)
        if not good.any():
            return
        columns = (residual, measured, velocity, displacement)
        e, f, v, x = (column[good] for column in columns)
        end = float(stamp[good][-1]) / 1e9
        if not 0.0 <= end - self._open.start <= 2.0 * self._window:  # also the first, and a clock that was set
            self._open = _OpenWindow(float(stamp[good][0]) / 1e9)
        window = self._open
        window.count += e.size
        window.sums += [e @ e, f @ f, v @ v, e.sum(), x.sum(), x @ x, temperature * e.size, f.sum()]
        if end - window.start >= self._window:
            self._close(end)

    def _close(self, end: float) -> None:
        closed, self._open = self._open, _OpenWindow(end)
        squared, force, speed, bias, place, stroke, temperature, _ = closed.sums / closed.count
        self.rms_n = float(np.sqrt(squared))
        if speed < _LEAST_SPEED**2 or force <= 0.0:
            return
        deviation = float(np.sqrt(max(stroke - place**2, 0.0)))
        window = WindowError(
            end, float(np.sqrt(squared / force)), self.rms_n, (temperature, np.sqrt(speed), deviation, abs(bias))
        )
        if len(self._reference) < REFERENCE:
            self._reference.append(window)
        self.windows = [*self.windows[-_MOST_WINDOWS + 1 :], window]
        limit = max(self._factor * self.reference, self.reference + _LEAST_GROWTH)
        self.is_alarm = len(self._reference) == REFERENCE and self.error > limit * (_RELEASE if self.is_alarm else 1.0)

    @property
    def reference(self) -> float:
        """The error at the beginning; NaN before the first window."""
        return _median([window.error for window in self._reference])

    @property
    def error(self) -> float:
        """The error now; NaN before the first window."""
        return _median([window.error for window in self.windows[-RECENT:]])

    def sentence(self) -> str:
        """The development of the error in words."""
        if not self.windows:
            return "no error known yet"
        if not self.is_alarm:
            return f"error {100 * self.error:.0f} % of the measured force"
        minutes = (self.windows[-1].end - self._reference[0].end) / 60.0
        since = f"{minutes:.0f} min" if minutes >= 2.0 else f"{60 * minutes:.0f} s"
        cause = self._related()
        return f"{self.name}: error grew from {100 * self.reference:.0f} % to {100 * self.error:.0f} % in {since}" + (
            f", grows with {cause}" if cause else ""
        )

    def _related(self) -> str:
        """The quantity that the error follows most closely, "" if it follows none."""
        if len(self.windows) < _LEAST_RELATED:
            return ""
        errors = np.array([window.error for window in self.windows])
        values = np.array([window.quantities for window in self.windows])
        force = np.median([window.rms_n for window in self.windows] / errors)
        _, speed, stroke, _ = _LEAST_VARIATION * np.median(values, axis=0)
        least = (_LEAST_WARMING, speed, stroke, _LEAST_GROWTH * force)
        varies = np.subtract(*np.percentile(values, [90.0, 10.0], axis=0)) > least  # False if one is NaN
        found = {name: rank_correlation(values[:, i], errors) for i, name in enumerate(QUANTITIES) if varies[i]}
        best = max(found, key=found.get, default="")
        return best if best and found[best] > _RELATED else ""


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")
