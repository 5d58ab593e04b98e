"""A column map guessed from titles, units, ranges, derivatives between channels, and the sign of power.

Information that the file lacks is reported: as an assumption if everything else supports it, else as a doubt. A guess
with a doubt must not be used before a person has checked it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench import read_parts
from damper_estimator.recordings.bench_table import Column
from damper_estimator.recordings.column_map import column_map_of
from damper_estimator.recordings.guess_clock import guess_clock
from damper_estimator.recordings.guess_physics import Motion, check_signs, motion_of, slope_of
from damper_estimator.recordings.guess_sheet import Sheet, read_sheet
from damper_estimator.recordings.guess_words import Title, read_title
from damper_estimator.recordings.quantities import QUANTITIES

_SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "in/s": 0.0254}
_BOUNDS = {  # SI; half the range between the ends, or the largest value
    "displacement": (2e-4, 1.0),
    "force": (3.0, 3e5),
    "temperature": (-80.0, 400.0),
    "pressure": (0.0, 1e8),
    "command": (0.0, 200.0),
    "acceleration": (0.0, 1e4),
}
_AGREES = 0.1  # share by which a slope and the velocity channel can differ


@dataclass(frozen=True)
class ColumnGuess:
    """A column and its guessed meaning.

    Attributes:
        column: as in a column map.
        quantity: "" if it is not used; else of `quantities.QUANTITIES`, or ``time``.
        damper: its name.
        unit: of its numbers; "" if it has none.
        scale: -1 if its sign is reversed.
        why: the reason in words.
    """

    column: Column
    title: str
    quantity: str
    damper: str
    unit: str
    scale: float
    why: str


@dataclass(frozen=True)
class Guess:
    """A guessed column map.

    Attributes:
        columns: every column of the file.
        time, text, split: as in a column map.
        assumed: assumptions that the file does not confirm.
        doubts: questions that a person has to decide before the map is used.
    """

    path: Path
    columns: tuple[ColumnGuess, ...]
    time: Mapping[str, object]
    text: Mapping[str, object]
    split: Mapping[str, object]
    assumed: tuple[str, ...]
    doubts: tuple[str, ...]

    def content(self) -> dict[str, object]:
        """The column map, for `column_map.load_column_maps`."""
        dampers: dict[str, dict[str, object]] = {}
        for column in self.columns:
            if column.quantity in QUANTITIES:
                scale = {"scale": column.scale} if column.scale != 1.0 else {}
                entry = {"column": column.column, "unit": column.unit} | scale
                dampers.setdefault(column.damper, {})[column.quantity] = entry
        content: dict[str, object] = {"dampers": dampers, "time": dict(self.time)}
        content |= {"text": dict(self.text)} if self.text else {}
        return content | ({"split": dict(self.split)} if self.split else {})

    def map_text(self) -> str:
        """The column map as a file, with assumptions and doubts as comments."""
        notes = [f"guessed from {self.path.name}; config/columns/example.yaml explains every key"]
        notes += [f"assumed: {text}" for text in self.assumed] + [f"IN DOUBT: {text}" for text in self.doubts]
        comments = "".join(f"# {' '.join(text.split())}\n" for text in notes)
        return comments + yaml.safe_dump(self.content(), sort_keys=False, allow_unicode=True, default_flow_style=None)


def guess_columns(path: Path) -> Guess:
    """Guesses the column map of a CSV, text or MAT file.

    Raises:
        InputError: if it cannot be read, or contains no table of numbers.
    """
    sheet = read_sheet(path)
    titles = [read_title(title, unit) for title, unit in zip(sheet.titles, sheet.units, strict=True)]
    doubts = [title.clash for title in titles if title.clash]
    clock = guess_clock(sheet, titles)
    assumed, doubts = [*clock.assumed], [*doubts, *clock.doubts]
    columns = [
        ColumnGuess(
            column, title, "time" if i == clock.index else "", "", "", 1.0, clock.why if i == clock.index else ""
        )
        for i, (column, title) in enumerate(zip(sheet.columns, sheet.titles, strict=True))
    ]
    dampers = sorted({title.damper for title in titles if title.damper}) or [""]
    for damper in dampers:
        found = _of_damper(sheet, titles, damper, clock.seconds, doubts)
        name = damper or "damper"
        for quantity, (i, unit, why) in found.items():
            columns[i] = replace(columns[i], quantity=quantity, damper=name, unit=unit, why=why)
        _correct_signs(sheet, columns, found, clock.seconds, assumed, doubts)
    split = {"restart": True} if clock.restarts else {}
    guess = Guess(path, tuple(columns), clock.entry, sheet.text, split, tuple(assumed), tuple(dict.fromkeys(doubts)))
    return guess if guess.doubts else _checked(guess)


def _checked(guess: Guess) -> Guess:
    """The guess, with a doubt if the file cannot be read by the guessed map."""
    try:
        read_parts(guess.path, column_map_of(guess.content(), str(guess.path)))
    except InputError as error:
        return replace(guess, doubts=(f"the guessed map does not fit: {error}",))
    return guess


def _of_damper(sheet: Sheet, titles: list[Title], damper: str, seconds, doubts: list[str]) -> dict[str, tuple]:
    """Column, unit and reason by quantity for one damper."""
    candidates = [i for i, title in enumerate(titles) if title.damper in (damper, "")]
    found: dict[str, tuple] = {}
    speed = _chosen(sheet, titles, candidates, "velocity", None, [])
    rate = None
    if speed is not None and seconds is not None and titles[speed].unit:
        rate = _SPEEDS[titles[speed].unit] * sheet.numbers[speed]
    for quantity in QUANTITIES:
        essential = quantity in ("displacement", "force")
        i = _chosen(sheet, titles, candidates, quantity, rate if quantity == "displacement" else None, doubts, seconds)
        where = f" of {damper}" if damper else ""
        if i is None:
            if essential:
                doubts.append(f"no column is clearly the {quantity}{where}")
            continue
        unit, why = _unit_of(sheet, titles[i], i, quantity, rate, seconds, doubts)
        if unit and _in_range(sheet.numbers[i], quantity, unit, sheet.titles[i] or i + 1, essential, doubts):
            found[quantity] = (i, unit, why)
    return found


def _chosen(
    sheet: Sheet, titles: list[Title], candidates: list[int], quantity: str, rate, doubts: list[str], seconds=None
) -> int | None:
    """The column of a quantity; None if there is none, or it is ambiguous."""
    fits = [i for i in candidates if titles[i].quantity == quantity and not titles[i].target]
    fits = [i for i in fits if np.isfinite(sheet.numbers[i]).mean() > 0.5 or quantity not in ("displacement", "force")]
    fits = [i for i in fits if np.isfinite(sheet.numbers[i]).any()]
    named = [i for i in fits if titles[i].damper] or fits
    moving = [i for i in named if np.nanstd(sheet.numbers[i]) > 0] or named
    if len(moving) > 1 and rate is not None:
        matched = [i for i in moving if abs(slope_of(sheet.numbers[i], seconds, rate)[1]) > 0.95]
        moving = matched or moving
    if len(moving) > 1:
        names = ", ".join(repr(sheet.titles[i] or i + 1) for i in moving)
        if quantity in ("displacement", "force", "command"):
            doubts.append(f"several columns could be the {quantity}: {names}")
            return None if quantity == "command" else moving[0]
        return None
    return moving[0] if moving else None


def _unit_of(sheet: Sheet, title: Title, i: int, quantity: str, rate, seconds, doubts: list[str]) -> tuple[str, str]:
    """Unit of a column, and the reason; that of a displacement is checked or found by the velocity channel."""
    name = repr(sheet.titles[i] or i + 1)
    known = QUANTITIES[quantity].units
    if quantity == "displacement" and rate is not None and seconds is not None:
        slope, agreement = slope_of(sheet.numbers[i], seconds, rate)
        if abs(agreement) > 0.95:
            found = [unit for unit, (factor, _) in known.items() if abs(abs(slope) / factor - 1.0) < _AGREES]
            if title.unit and title.unit not in found:
                doubts.append(f"{name} is titled in {title.unit}, but its slope is not the velocity column")
            elif not title.unit and len(found) == 1:
                return found[0], "its slope is the velocity column"
            elif title.unit and slope < 0:
                doubts.append(f"{name} and the velocity column have opposite signs")
    if title.unit in known:
        return title.unit, "title and unit" if title.unit else ""
    doubts.append(f"the unit of {name} ({quantity}) is not named; it can be {', '.join(list(known)[:5])}")
    return next(iter(known)), "title"


def _in_range(values: np.ndarray, quantity: str, unit: str, name: object, essential: bool, doubts: list[str]) -> bool:
    factor, offset = QUANTITIES[quantity].units[unit]
    low, high = _BOUNDS[quantity]
    finite = values[np.isfinite(values)] * factor + offset
    usual = np.quantile(finite, [0.001, 0.999])  # a spike says nothing of the unit
    size = 0.5 * float(np.ptp(usual)) if essential else float(np.max(np.abs(usual)))
    if quantity == "temperature":
        good = low <= finite.min() and finite.max() <= high
    else:
        good = low <= size <= high
    if not good:
        doubts.append(
            f"{name!r} as {quantity} in {unit} is {finite.min():.3g} to {finite.max():.3g} in SI units: not plausible"
        )
    return good or essential


def _correct_signs(
    sheet: Sheet, columns: list[ColumnGuess], found: Mapping, seconds, assumed: list[str], doubts: list[str]
) -> None:
    """Reverses signs so that the damper dissipates energy, if the file shows which one is wrong."""
    if seconds is None or not {"displacement", "force"} <= found.keys():
        return
    values = {}
    for quantity in ("displacement", "force"):
        i, unit, _ = found[quantity]
        values[quantity] = QUANTITIES[quantity].units[unit][0] * sheet.numbers[i]
    motion: Motion | None = motion_of(values["displacement"], values["force"], seconds)
    verdict = check_signs(motion)
    assumed += verdict.assumed
    doubts += verdict.doubts
    for quantity in verdict.reversed:
        i = found[quantity][0]
        columns[i] = replace(columns[i], scale=-1.0, why=f"{columns[i].why}; reversed because of the sign of power")
