"""The steps that a plan chooses from: what a rig can drive within its limits, in words and as motions."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from damper_estimator.planning.limits import Limits
from damper_estimator.planning.motions import acceleration_of, motion, speed_of
from damper_estimator.planning.rig import Rig

_FREQUENCIES = (0.1, 0.3, 0.7, 1.5, 3.0, 5.0, 8.0, 12.0, 16.0, 20.0, 25.0)  # Hz
_LEVELS = (1.0, 0.4, 0.12)  # of the largest amplitude at a frequency
_OFFSETS = (0.0, 0.6, -0.6)  # of the stroke to that side
_SLOWEST = 0.004  # m/s; a slower sine shows friction and noise alone, which a triangle does better
_CYCLES, _SHORTEST, _LONGEST = 6.0, 3.0, 12.0  # of a sine, s
_TRIANGLES = (0.005, 0.02, 0.08)  # m/s
_SAME = 0.999  # a crank's amplitude must not be scaled by more


@dataclass(frozen=True)
class Step:
    """A piece of a test, from rest to rest.

    Attributes:
        kind: of ``motions.KINDS``.
        values: of the kind.
        limits: within which it is driven.
        current, temperature: A and deg C while it is driven; None where they stay as they are.
        say: instruction for a driver, "" where a rig plays it.
    """

    kind: str
    values: Mapping[str, float]
    limits: Limits
    current: float | None = None
    temperature: float | None = None
    say: str = field(default="")

    @cached_property
    def displacement(self) -> np.ndarray:
        """(n,) m at the limits' rate."""
        return motion(self.kind, self.values, self.limits)

    @property
    def seconds(self) -> float:
        """Length."""
        return self.displacement.size / self.limits.rate

    @property
    def amplitude(self) -> float:
        """m, half of what is driven from end to end, the ramps to the mean position left out."""
        middle = self.limits.home + self.values.get("offset", 0.0)
        away = self.displacement - middle
        if self.kind == "hold":
            return 0.0
        return float(min(np.abs(away).max(), 0.5 * np.ptp(self.displacement)) if self.values.get("offset") else
                     0.5 * np.ptp(self.displacement))  # fmt: skip

    @property
    def cycles(self) -> float:
        """How often the same motion is driven; infinite where nothing moves."""
        if self.kind == "hold":
            return np.inf
        if self.kind == "triangle":
            return self.seconds * self.values["speed"] / (4.0 * self.amplitude)
        return self.seconds * self.values["frequency"] if self.kind in ("sine", "crank") else 1.0

    @property
    def is_random(self) -> bool:
        """Whether another motion of the same kind shows the same on average."""
        return self.kind in ("multisine", "road")

    def repeated(self, number: int) -> "Step":
        """The step when it is driven again for the ``number``-th time: a random motion has other phases then."""
        if not (number and self.is_random):
            return self
        return replace(self, values={**self.values, "seed": self.values.get("seed", 0.0) + 100.0 * number})

    @property
    def words(self) -> str:
        """What is driven, in one line."""
        if self.say:
            return f"{self.say}, {self.seconds:.0f} s"
        return f"{_words(self)}{self.conditions}"

    @property
    def conditions(self) -> str:
        """At which current and temperature, "" where they stay."""
        words = "" if self.current is None else f", at {self.current:g} A"
        return words + ("" if self.temperature is None else f", at {self.temperature:g} deg C")

    def record(self) -> dict[str, object]:
        """For the plan's file."""
        speed = float(np.abs(speed_of(self.displacement, self.limits.rate)).max())
        acceleration = float(np.abs(acceleration_of(self.displacement, self.limits.rate)).max())
        return {
            "drive": self.words,
            "kind": self.kind,
            "seconds": round(self.seconds, 3),
            "lowest_mm": round(1e3 * float(self.displacement.min()), 3),
            "highest_mm": round(1e3 * float(self.displacement.max()), 3),
            "speed_m_s": round(speed, 4),
            "acceleration_m_s2": round(acceleration, 3),
        }


def _words(step: Step) -> str:
    values = step.values
    mean = values.get("offset", 0.0)
    about = f" about {1e3 * (step.limits.home + mean):+.1f} mm" if mean or abs(step.limits.home) > 5e-5 else ""
    seconds = f"{step.seconds:.1f} s"
    size = f"{1e3 * step.amplitude:.2g} mm" if step.amplitude < 0.01 else f"{1e3 * step.amplitude:.1f} mm"
    if step.kind in ("sine", "crank"):
        return f"sine of {values['frequency']:g} Hz, {size}{about}, {seconds}"
    if step.kind == "sweep":
        return f"sweep from {values['frequency']:g} to {values['to']:g} Hz, at most {size}{about}, {seconds}"
    if step.kind == "triangle":
        return f"triangle at {1e3 * values['speed']:g} mm/s, {size}{about}, {seconds}"
    if step.is_random:
        return f"random motion from {values['frequency']:g} to {values['to']:g} Hz, at most {size}{about}, {seconds}"
    return f"hold at {1e3 * (step.limits.home + mean):+.1f} mm, {seconds}"


def steps_of(rig: Rig, limits: Limits, currents: bool, temperatures: bool) -> list[Step]:
    """All steps that a rig can drive.

    Args:
        currents, temperatures: whether anything depends on them, so that their levels make a difference.
    """
    motions = list({"crank": _cranked, "manoeuvres": _driven, "played": _played}[rig.kind](rig, limits))
    levels = (limits.current or (None,)) if currents else (None,)
    warm = (limits.temperature or (None,)) if temperatures else (None,)
    return [
        Step(kind, values, limits, current, temperature, say)
        for (kind, values, say), current, temperature in product(motions, levels, warm)
    ]


Motion = tuple[str, dict[str, float], str]


def _cranked(rig: Rig, limits: Limits) -> Iterator[Motion]:
    for frequency in _frequencies(limits):
        values = {"frequency": frequency, "seconds": _seconds(frequency)}
        if np.ptp(motion("crank", values, limits)) >= 2.0 * _SAME * limits.amplitude * 0.98:
            yield "crank", values, ""


def _driven(rig: Rig, limits: Limits) -> Iterator[Motion]:
    for number, manoeuvre in enumerate(rig.manoeuvres):
        low, high = max(manoeuvre.band[0], limits.frequency[0]), min(manoeuvre.band[1], limits.frequency[1])
        if low < high:
            values = {
                "frequency": low,
                "to": high,
                "speed": manoeuvre.speed,
                "seconds": manoeuvre.seconds,
                "seed": float(number),
            }
            yield "road", values, manoeuvre.say


def _played(rig: Rig, limits: Limits) -> Iterator[Motion]:
    yield from _sines(limits)
    low, high = limits.frequency
    stroke = min(limits.high - limits.home, limits.home - limits.low)
    for share in (1.0, 0.35):
        values = {"frequency": low_of(low), "to": high, "seconds": 12.0, "amplitude": stroke}
        yield "sweep", values | {"speed": share * limits.speed}, ""
        for seed, ends in enumerate(((low_of(low), high), (low_of(low), min(3.0, high)), (min(5.0, 0.5 * high), high))):
            if ends[0] < ends[1]:
                values = {"frequency": ends[0], "to": ends[1], "seconds": 10.0, "seed": float(seed)}
                yield "multisine", values | {"share": share}, ""
    for speed, share in product(_TRIANGLES, (0.9, 0.3)):
        amplitude = min(share * stroke, 0.25 * _LONGEST * speed)
        if speed <= limits.speed and speed / (4.0 * amplitude) >= 0.5 * low:
            yield "triangle", {"speed": speed, "amplitude": amplitude, "seconds": _LONGEST}, ""
    if limits.mean_positions:
        for offset in _offsets(limits):
            yield "hold", {"offset": offset, "seconds": 3.0}, ""


def low_of(frequency: float) -> float:
    """Hz, where sweeps begin: slower ones take their time."""
    return max(frequency, 0.3)


def _sines(limits: Limits) -> Iterator[Motion]:
    for offset in _offsets(limits):
        room = min(limits.high - limits.home - offset, limits.home + offset - limits.low)
        for frequency in _frequencies(limits):
            turn = 2.0 * np.pi * frequency
            largest = min(room, limits.speed / turn, limits.acceleration / turn**2)
            for level in _LEVELS if not offset else _LEVELS[:1]:
                if level * largest * turn >= _SLOWEST:
                    values = {"frequency": frequency, "amplitude": level * largest, "seconds": _seconds(frequency)}
                    yield "sine", values | ({"offset": offset} if offset else {}), ""


def _frequencies(limits: Limits) -> Sequence[float]:
    low, high = limits.frequency
    inside = [f for f in _FREQUENCIES if low <= f <= high]
    ends = [
        end for end in (low, high) if end >= 1.0 / _LONGEST and all(abs(np.log(end / known)) > 0.2 for known in inside)
    ]
    return sorted(float(f"{f:.3g}") if low <= float(f"{f:.3g}") <= high else f for f in [*inside, *ends])


def _offsets(limits: Limits) -> list[float]:
    sides = [0.0 if not offset else offset * (limits.high - limits.home if offset > 0 else limits.home - limits.low)
             for offset in _OFFSETS]  # fmt: skip
    return sides if limits.mean_positions else sides[:1]


def _seconds(frequency: float) -> float:
    return float(np.clip(_CYCLES / frequency, _SHORTEST, _LONGEST))
