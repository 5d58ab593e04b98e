"""Times of the rows of a bench file."""

from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench_table import Table
from damper_estimator.recordings.column_map import Clock
from damper_estimator.recordings.quantities import TIME_UNITS

NANOSECONDS = 1_000_000_000
EPOCH = 946_684_800  # s; files without a date are dated 2000-01-01 00:00 UTC
_UNIX = 1e8  # s; larger numbers are Unix times
_LATEST = 2**31  # s; end of ROS time
_EXACT = 1e-6  # of a step; smaller deviations from an even grid are rounding
_PAUSE = 3.0  # steps; a longer one ends a run of even steps


@dataclass(frozen=True, eq=False)
class Times:
    """Seconds of each row (rows,) from ``start`` (s, Unix time), and whether they come from the file."""

    start: int
    seconds: np.ndarray
    measured: bool

    def stamps(self, rows: slice) -> np.ndarray:
        """Times of some rows as ns since 1970, (n,) int64; the parts of a file without times all begin at the same
        time.
        """
        seconds = self.seconds[rows] if self.measured else self.seconds[rows] - self.seconds[rows.start]
        return self.start * NANOSECONDS + np.rint(seconds * NANOSECONDS).astype(np.int64)


def read_times(table: Table, clock: Clock) -> Times:
    """Reads a time column, or uses a fixed rate.

    Times that were printed with too few digits are restored to the even grid that they were rounded from: 3005 Hz with
    four decimals shows steps of 0.3 and 0.4 ms, and a velocity from these would be wrong by 11 %.

    Raises:
        InputError: for a missing column, header line or date, and for times that are no numbers.
    """
    times = _fixed_times(table, clock) if clock.column is None else _times_of_file(table, clock)
    if ((times.start + times.seconds < 0) | (times.start + times.seconds >= _LATEST)).any():
        low, high = times.seconds.min(), times.seconds.max()
        raise InputError(
            f"{table.path}: times from {low:g} to {high:g} s are no plausible dates; check time in the column map"
        )
    return times


def _fixed_times(table: Table, clock: Clock) -> Times:
    return Times(EPOCH, np.arange(table.rows) * _interval(table, clock), False)


def _times_of_file(table: Table, clock: Clock) -> Times:
    if clock.format is not None:
        seconds, resolution = _dates(table, clock), table.resolution(clock.column)
    else:
        unit = TIME_UNITS[clock.unit]
        seconds, resolution = table.numbers(clock.column) * unit, table.resolution(clock.column) * unit
    if not np.isfinite(seconds).all():
        bad = int((~np.isfinite(seconds)).sum())
        raise InputError(
            f"{table.path}: {bad} times of column {clock.column!r} are no numbers; correct them or give time.rate"
        )
    resolution = max(resolution, 2 * float(np.spacing(np.abs(seconds).max())))
    if seconds[0] < _UNIX:
        return Times(EPOCH, even_steps(seconds, resolution), True)
    start = int(seconds[0])
    return Times(start, even_steps(seconds - start, resolution), True)


def _interval(table: Table, clock: Clock) -> float:
    value = clock.interval if clock.rate is None else clock.rate
    number = table.header_number(value) if isinstance(value, str) else float(value)
    if not 0 < number < float("inf"):
        raise InputError(f"{table.path}: {value!r} is {number:g}, which is no valid rate; give time.rate in Hz")
    return number if clock.rate is None else 1.0 / number


def _dates(table: Table, clock: Clock) -> np.ndarray:
    seconds = np.empty(table.rows)
    for row, text in enumerate(table.texts(clock.column)):
        try:
            found = datetime.strptime(text, clock.format).replace(tzinfo=UTC)
            # Times of day have no date: they count from the day of files without a date.
            seconds[row] = found.timestamp() if "%y" in clock.format.lower() else found.replace(year=2000).timestamp()
        except ValueError as error:
            what = f"row {row + 1}: {text!r} is no date of the form {clock.format!r}"
            raise InputError(f"{table.path}: {what}; correct time.format (as in Python's strptime)") from error
    return seconds


def even_steps(seconds: np.ndarray, resolution: float) -> np.ndarray:
    """Restores runs of even steps, blurred only by rounding, to their grid, (t_end - t_0) / (n - 1) apart.

    Args:
        seconds: times as printed, (n,).
        resolution: smallest step of their notation; each time can be wrong by as much.

    Returns:
        Times (n,); runs whose steps differ by more than rounding stay unchanged.
    """
    if len(seconds) < 3:
        return seconds
    steps = np.diff(seconds)
    breaks = np.flatnonzero((steps > _PAUSE * np.median(steps) + resolution) | (steps < -resolution)) + 1
    return np.concatenate([_even_run(run, resolution) for run in np.split(seconds, breaks)])


def _even_run(run: np.ndarray, resolution: float) -> np.ndarray:
    if len(run) < 3:
        return run
    grid = np.linspace(run[0], run[-1], len(run))
    tolerance = resolution * (1 + _EXACT) + _EXACT * (grid[1] - grid[0])
    return grid if np.abs(run - grid).max() <= tolerance else run
