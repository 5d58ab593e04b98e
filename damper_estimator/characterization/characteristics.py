"""A damper's characteristic diagrams and conclusions: types by band, semi-active part, a model structure to fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.characterization.loops import FEWEST_RANDOM, FEWEST_STEADY, Loop, mean_loops
from damper_estimator.characterization.model_structure import TABLE_10_READING, Structure, derive
from damper_estimator.characterization.patterns import Pattern, classify
from damper_estimator.characterization.points import Line, Point, characteristic_points
from damper_estimator.characterization.quasi_static import QuasiStatic
from damper_estimator.characterization.subtraction import Difference, difference, semi_active
from damper_estimator.errors import InputError
from damper_estimator.signals import Measurement

BANDS = {"low": (0.5, 3.0), "medium": (3.0, 7.0), "high": (7.0, 15.0)}  # Hz
_EDGE = 0.98  # a test at nominally 3 Hz belongs to the band from 3 Hz on


@dataclass(frozen=True)
class Diagram:
    """One mean loop and its analysis.

    Attributes:
        loop, pattern: the loop and its type.
        points, lines: A to H and a to h.
        role: ``total``, ``semi_active``, or the quantity by which a subtracted recording differs (``command``,
            ``pressure``, ``setting``).
        subtrahend: the command (or pressure) whose loop was subtracted; NaN for none.
    """

    loop: Loop
    pattern: Pattern
    points: dict[str, Point]
    lines: dict[str, Line]
    role: str = "total"
    subtrahend: float = float("nan")


@dataclass(frozen=True)
class Band:
    """Pattern types of one frequency range; None without suitable recordings, with the reason.

    Attributes:
        name, low, high: Hz.
        passive, semi_active: types, from the fastest motion in the band; the semi-active one as in Table 10.
        why: the reasoning, or the reason for None.
    """

    name: str
    low: float
    high: float
    passive: int | None
    semi_active: int | None
    why: str


@dataclass(frozen=True)
class Characterization:
    """Everything that ``characterize`` finds about one damper.

    Attributes:
        damper, recordings: the inputs.
        diagrams: one per operating point.
        differences: semi-active parts and requested subtractions.
        bands: types by frequency range.
        structure: derived from Tables 9 and 10; None if no band has a type.
        notes: remarks on the results.
    """

    damper: str
    recordings: tuple[str, ...]
    diagrams: tuple[Diagram, ...]
    differences: tuple[Diagram, ...]
    bands: tuple[Band, ...]
    structure: Structure | None
    notes: tuple[str, ...]


def characterize(
    measurements: Sequence[Measurement],
    subtracted: Sequence[Measurement] = (),
    slow: QuasiStatic | None = None,
) -> Characterization:
    """Characteristic diagrams of one damper.

    Args:
        measurements: of the damper, sine tests above all.
        subtracted: recordings at another setting, whose loops are subtracted from those of the same motion.
        slow: quasi-static force, subtracted first.

    Raises:
        InputError: if there is no suitable cycle, or no equal motion to subtract.
    """
    notes: list[str] = []
    loops = _loops(measurements, slow, notes)
    if not loops:
        raise InputError(
            f"{measurements[0].recording}: has no motion that characterizes a damper; drive "
            f"{FEWEST_STEADY + 1} consecutive sine cycles of one frequency and amplitude, "
            f"or {FEWEST_RANDOM} single cycles close to a sine"
        )
    passive, added = semi_active(loops)
    requested = _requested(loops, _loops(subtracted, slow, notes), measurements, subtracted) if subtracted else []
    differences = [*(_of_difference(d, "semi_active") for d in added), *(_of_difference(d) for d in requested)]
    diagrams = tuple(_diagram(loop) for loop in loops)
    of_passive = [d for d in diagrams if any(d.loop is loop for loop in passive)]
    active = [d for d in differences if d.role == "semi_active"]
    bands = tuple(_band(name, of_passive, active) for name in BANDS)
    notes += [*_more_notes(loops, passive, active), *_unlike([*added, *requested])]
    return Characterization(
        damper=measurements[0].damper,
        recordings=tuple(m.recording for m in measurements),
        diagrams=diagrams,
        differences=tuple(differences),
        bands=bands,
        structure=_structure(bands, of_passive),
        notes=tuple(dict.fromkeys(notes)),
    )


def _loops(measurements: Sequence[Measurement], slow: QuasiStatic | None, notes: list[str]) -> list[Loop]:
    forces = [m.force if slow is None else slow.remaining(m) for m in measurements]
    if slow is not None:
        share = max(slow.outside(m.kinematics.displacement) for m in measurements)
        if share > 0.01:
            notes.append(
                f"the slow test covers less stroke: {100 * share:.0f} % of the samples lie outside, where "
                "its value at the end was subtracted"
            )
    steady, single = mean_loops(measurements, forces)
    if single:
        notes.append(
            f"{len(single)} of the diagrams are means over single cycles that look like a sine, taken from a "
            "motion that is not one: their histories differ, so take their hysteresis with caution"
        )
    return [*steady, *single]


def _diagram(loop: Loop, role: str = "total", subtrahend: float = float("nan")) -> Diagram:
    return Diagram(loop, classify(loop), *characteristic_points(loop), role, subtrahend)


def _of_difference(found: Difference, role: str = "") -> Diagram:
    subtrahend = found.subtrahend.pressure if found.quantity == "pressure" else found.subtrahend.command
    return _diagram(found.loop, role or found.quantity, subtrahend)


def _requested(
    loops: Sequence[Loop],
    others: Sequence[Loop],
    measurements: Sequence[Measurement],
    subtracted: Sequence[Measurement],
) -> list[Difference]:
    found = [d for loop in loops if (d := difference(loop, others)) is not None]
    if not found:
        motions = (
            ", ".join(f"{loop.frequency:.3g} Hz {1e3 * loop.amplitude:.3g} mm" for loop in others) or "no steady cycles"
        )
        raise InputError(
            f"{subtracted[0].recording}: has no motion in common with {measurements[0].recording}; it has "
            f"{motions}; two settings are subtracted at equal frequency and amplitude"
        )
    return found


def _unlike(differences: Sequence[Difference]) -> list[str]:
    """A note if the motions differ."""
    worst = max((d.velocity_difference for d in differences), default=0.0)
    return (
        [f"motions subtracted from each other differ by up to {100 * worst:.0f} % in peak velocity"]
        if worst > 0.05
        else []
    )


def _inside(diagrams: Sequence[Diagram], band: str) -> list[Diagram]:
    low, high = BANDS[band]
    return [
        d
        for d in diagrams
        if low * _EDGE <= d.loop.frequency < high * _EDGE or (band == "high" and low <= d.loop.frequency <= high)
    ]


def _representative(diagrams: Sequence[Diagram]) -> Diagram | None:
    """The diagram that represents a band: the fastest motion, and among equally fast ones the largest command."""
    return max(
        diagrams,
        key=lambda d: (d.loop.steady, round(d.loop.peak_velocity, 2), abs(np.nan_to_num(d.loop.command))),
        default=None,
    )


def _band(name: str, passive: Sequence[Diagram], active: Sequence[Diagram]) -> Band:
    low, high = BANDS[name]
    p, sa = _representative(_inside(passive, name)), _representative(_inside(active, name))
    words = []
    for diagram, label in ((p, "passive"), (sa, "semi-active")):
        if diagram is not None:
            loop = diagram.loop
            words.append(
                f"{label} at {loop.frequency:.3g} Hz, {1e3 * loop.amplitude:.3g} mm: {diagram.pattern.because}"
            )
    if p is None and sa is None:
        words.append(
            f"no steady sine cycles between {low:g} and {high:g} Hz, nor {FEWEST_RANDOM} similar single ones; "
            "drive this range"
        )
    kind = None if sa is None else sa.pattern.type
    reading = TABLE_10_READING.get(kind, kind)
    if reading != kind:
        words.append(
            f"by its shape the semi-active part is type {kind}, which Table 10 does not contain; treated as {reading}"
        )
    return Band(name, low, high, None if p is None else p.pattern.type, reading, "; ".join(words))


def _structure(bands: Sequence[Band], passive: Sequence[Diagram]) -> Structure | None:
    types = {band.name: band.passive for band in bands if band.passive is not None}
    active = {band.name: band.semi_active for band in bands if band.semi_active is not None}
    shown = [d for name in BANDS if (d := _representative(_inside(passive, name))) is not None]
    return derive(types, active, all(d.pattern.symmetric for d in shown)) if types else None


def _more_notes(loops: Sequence[Loop], passive: Sequence[Loop], active: Sequence[Diagram]) -> list[str]:
    notes = []
    commands = [loop.command for loop in passive if np.isfinite(loop.command)]
    if commands and min(map(abs, commands)) > 0.05 * max(
        abs(loop.command) for loop in loops if np.isfinite(loop.command)
    ):
        notes.append(f"the smallest command is {min(commands):.3g}, not 0: the part called passive includes its effect")
    if len(passive) < len(loops) and not active:
        notes.append("no two commands have the same frequency and amplitude: the semi-active part cannot be separated")
    lowest = min(band[0] for band in BANDS.values())
    slow = [loop for loop in loops if loop.frequency < _EDGE * lowest]
    if slow:
        notes.append(f"{len(slow)} operating points lie below {lowest:g} Hz, outside the bands of the method")
    return notes
