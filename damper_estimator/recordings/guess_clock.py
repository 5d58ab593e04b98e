"""The time column of a bench file and its unit, or the rate that the file names."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from damper_estimator.recordings.guess_sheet import Sheet
from damper_estimator.recordings.guess_words import Title
from damper_estimator.recordings.quantities import TIME_UNITS

_LEAST_RATE, _MOST_RATE = 15.0, 50_000.0  # Hz at which dampers are logged
_EVEN = 0.05  # share by which steps of a time can differ in the middle half


@dataclass(frozen=True, eq=False)
class ClockGuess:
    """The time.

    Attributes:
        index: its column; -1 for none.
        entry: ``time`` of the column map.
        seconds: (n,) of each row; None if unknown.
        restarts: whether the time restarts within the file.
    """

    index: int
    entry: Mapping[str, object]
    seconds: np.ndarray | None
    why: str = ""
    restarts: bool = False
    assumed: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()


def guess_clock(sheet: Sheet, titles: Sequence[Title]) -> ClockGuess:
    """The time of a file's rows."""
    rising = [i for i, values in enumerate(sheet.numbers) if _rises(values)]
    named = [i for i in rising if titles[i].quantity == "time"]
    if len(named) > 1:
        fine = [i for i in named if _step(sheet.numbers[i]) > 0 and titles[i].unit]
        named = fine[:1] or named
    if named:
        return _by_column(sheet, titles[named[0]], named[0], len(named) > 1)
    if sheet.dates:
        return _by_date(sheet)
    if sheet.rate is not None:
        return _by_rate(sheet, sheet.rate, "a line above the numbers names the rate")
    untitled = [i for i in rising if not titles[i].quantity and not sheet.titles[i]]
    if untitled:
        guess = _by_column(sheet, titles[untitled[0]], untitled[0], False)
        return replace(guess, doubts=(*guess.doubts, f"column {untitled[0] + 1} has no title; it rises like a time"))
    rows = len(sheet.numbers[0])
    doubt = "no column rises like a time, and no line names a rate: give time.rate in Hz"
    return ClockGuess(-1, {"rate": 1000}, np.arange(rows) * 1e-3, doubts=(doubt,))


def _by_column(sheet: Sheet, title: Title, index: int, several: bool) -> ClockGuess:
    values, doubts, assumed = sheet.numbers[index], [], []
    if several:
        doubts.append("several columns could be the time")
    step = _step(values)
    unit = title.unit if title.quantity == "time" else ""
    possible = [name for name, factor in TIME_UNITS.items() if _LEAST_RATE <= 1.0 / (step * factor) <= _MOST_RATE]
    likely = [name for name in possible if name in ("s", "ms", "us")]
    if unit and unit not in possible:
        doubts.append(f"a step of the time is {step:g} {unit}, a rate of {1.0 / (step * TIME_UNITS[unit]):.3g} Hz")
    elif not unit and len(likely) == 1:
        unit = likely[0]
        assumed.append(f"the time is in {unit}: its steps of {step:g} mean {1.0 / (step * TIME_UNITS[unit]):.4g} Hz")
    elif not unit:
        doubts.append(f"the unit of the time is not named; its steps are {step:g}")
        unit = likely[0] if likely else "s"
    if not np.isfinite(values).all():
        doubts.append(f"{int((~np.isfinite(values)).sum())} times are no numbers")
    entry = {"column": sheet.columns[index], "unit": unit}
    restarts = bool((np.diff(values) < 0).any())
    return ClockGuess(
        index, entry, values * TIME_UNITS[unit], "it rises evenly", restarts, tuple(assumed), tuple(doubts)
    )


def _by_date(sheet: Sheet) -> ClockGuess:
    index, form = next(iter(sheet.dates.items()))
    rows = len(sheet.numbers[0])
    entry = {"column": sheet.columns[index], "format": form}
    return ClockGuess(
        index, entry, _date_seconds(sheet, index, form, rows), f"dates of the form {form}", doubts=_several(sheet)
    )


def _several(sheet: Sheet) -> tuple[str, ...]:
    return ("several columns contain dates or times",) if len(sheet.dates) > 1 else ()


def _date_seconds(sheet: Sheet, index: int, form: str, rows: int) -> np.ndarray | None:
    texts = sheet.texts.get(index)
    if texts is None or len(texts) != rows:
        return None
    first = datetime.strptime(texts[0], form)
    try:
        return np.array([(datetime.strptime(text, form) - first).total_seconds() for text in texts])
    except ValueError:
        return None


def _by_rate(sheet: Sheet, rate: float, why: str) -> ClockGuess:
    seconds = np.arange(len(sheet.numbers[0])) / rate
    doubts = () if _LEAST_RATE <= rate <= _MOST_RATE else (f"the rate {rate:g} Hz is implausible for a damper",)
    return ClockGuess(-1, {"rate": rate}, seconds, why, assumed=(f"{rate:g} Hz: {why}",), doubts=doubts)


def _rises(values: np.ndarray) -> bool:
    """Whether numbers rise in mostly even steps; a few restarts are allowed."""
    known = values[np.isfinite(values)]
    if len(known) < 10 or len(known) < 0.9 * len(values):
        return False
    steps = np.diff(known)
    if (steps > 0).mean() < 0.98:
        return False
    low, middle, high = np.percentile(steps, (10, 50, 90))
    return bool(middle > 0 and high - low < 3.0 * middle)


def _step(values: np.ndarray) -> float:
    steps = np.diff(values[np.isfinite(values)])
    forward = steps[steps > 0]
    return float(np.mean(forward[forward <= 3 * np.median(forward)]))
