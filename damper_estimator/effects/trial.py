"""How an effect is tried on a recording: start values of its parameters and their physical limits.

Lengths, speeds and forces of dampers differ by orders of magnitude, and effects without limits imitate each other (long
pre-sliding friction looks like a spring, an end stop at mid-stroke like gas): an effect that represents a phenomenon
states its physical limits for the ranges of a recording.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Number = float | tuple[float, ...]


class Untestable(Exception):
    """An effect cannot be tried on a recording; the message says what is missing."""


@dataclass(frozen=True)
class Ranges:
    """The ranges that recordings of a damper cover; SI units.

    Attributes:
        compression, extension: smallest and largest displacement without the outermost thousandth, m.
        speed: 99.5 % of the absolute velocities are below it, m/s.
        acceleration: the same, m/s^2.
        force: rms about the mean, N.
        seconds: compared duration of the shortest recording.
        command, temperature: lowest and highest (A, deg C); None where not recorded.
        model_command, model_temperature: the same of what the model was identified at, where its parameters hold; None
            if unknown.
        at_rest, oil_at_rest: the model's force at rest (N), the whole and without what acts beside the oil: the gas
            force, or a constant in a curve, which no change of the flow changes.
        spring_rate, preload: of a parallel spring in the gauge's force, as the signal maps state it (N/m, N).
        identified: phenomena that the model has with parameters that are identified.
        with_mean: whether the mean of the error is to be explained as well, because the gauge's zero is not free.
    """

    compression: float
    extension: float
    speed: float
    acceleration: float
    force: float
    seconds: float
    command: tuple[float, float] | None = None
    temperature: tuple[float, float] | None = None
    model_command: tuple[float, float] | None = None
    model_temperature: tuple[float, float] | None = None
    at_rest: float = 0.0
    oil_at_rest: float = 0.0
    spring_rate: float = 0.0
    preload: float = 0.0
    identified: frozenset[str] = frozenset()
    with_mean: bool = False

    @property
    def stroke(self) -> float:
        """Recorded stroke, m."""
        return self.extension - self.compression

    @property
    def least_stiffness(self) -> float:
        """Of a spring in series, N/m: it deflects by at most a twentieth of the recorded stroke."""
        return max(20.0 * self.force / self.stroke, 5e4)

    @property
    def most_mass(self) -> float:
        """Of moving parts, kg: 30, or more in front of a damper with much force, as that of a heavy fixture or of a
        column of oil in a hose.
        """
        return float(np.clip(3.0 * self.force / max(self.acceleration, 1e-9), 30.0, 300.0))

    @property
    def middle(self) -> float:
        """Middle of the recorded stroke, m."""
        return 0.5 * (self.extension + self.compression)

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Where a stop on the compressed and on the extended side may begin, m, wherever displacement is zero: a third
        of the recorded stroke is free of it.

        Raises:
            Untestable: for less than 3 mm of stroke.
        """
        if self.stroke < 3e-3:
            raise Untestable("the stroke is too short to reach a stop")
        reach = 2.0 / 3.0 * self.stroke
        return (self.compression, self.compression + reach), (self.extension - reach, self.extension)


@dataclass(frozen=True)
class Trial:
    """One way to try an effect.

    Attributes:
        values: settings and start values by name; the effect's default for the others.
        limits: lowest and highest physical value of parameters by name, narrower than their bounds.
        starts: further start values of parameters by name; the fit continues from the best start.
        exclusion: says why the effect with some parameters and settings is no longer what it represents, "" if it is;
            for limits on several of them together.
        imitates: name of the form-free test of what such values imitate; where the effect explains clearly more than
            this test, it is what it represents.
        conditions: settings by name to try as well, where recordings do not say which apply; those that explain the
            fitted recordings best are taken.
        prior: how probable the effect is before its error is compared with that of others, relative to them, by what is
            known of the recordings otherwise.
        plausible: by how much its values lower the prior, 0 to 1, where two phenomena pass into each other.
        because: a sentence that says what speaks for it, if that is not seen in the recordings; "" otherwise.
    """

    values: Mapping[str, Number] = field(default_factory=dict)
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    starts: tuple[Mapping[str, float], ...] = ()
    exclusion: Callable[[Mapping[str, Any]], str] | None = None
    imitates: str = ""
    conditions: tuple[Mapping[str, float], ...] = ()
    prior: float = 1.0
    plausible: Callable[[Mapping[str, Any]], float] | None = None
    because: str = ""


Try = Callable[[Ranges], Trial]

_USUAL_TRAVEL = 6e-4  # m


def sliding_soon(travel: float) -> float:
    """How plausible dry friction is that slides after this travel (m): seals slide after some tenths of a millimetre,
    in a soft seat or lining later; what needs a longer travel is rather another memory.
    """
    return min(1.0, (_USUAL_TRAVEL / max(travel, 1e-9)) ** 4)


_BOTH = 0.2  # of the stronger stop: one that is weaker does not count


def leaves_no_middle(low: float, high: float, forces: tuple[float, float], ranges: Ranges) -> bool:
    """Whether two stops, which begin below ``low`` and above ``high`` (m) and reach such forces (N) at the ends of the
    recorded stroke, leave less than a third of it free between them. One alone always leaves a third.
    """
    return min(forces) > _BOTH * max(forces) and high - low < ranges.stroke / 3.0


_SHORTEST_MEMORY = 3e-4  # m


def slides_early(travel: float) -> str:
    """Why a hysteresis that slides after this travel (m) is dry friction; "" if it is not.

    Between this and the longest travel of friction it may be either.
    """
    return f"slides after {1e3 * travel:.2g} mm already: dry friction" if travel < _SHORTEST_MEMORY else ""


_LONGEST_YIELD = 2.5e-3  # m


def longest_yield(ranges: Ranges) -> float:
    """Longest travel in m over which a yield force builds up: a twentieth of the stroke, in short strokes more."""
    return max(0.05 * ranges.stroke, min(0.25 * ranges.stroke, _LONGEST_YIELD))


def ordinary(ranges: Ranges) -> Trial:
    """The effect's defaults and bounds."""
    return Trial()


def spread(**values: tuple[float, ...]) -> tuple[dict[str, float], ...]:
    """All combinations of start values: ``spread(delay=(1e-3, 5e-3), gain=(0.5,))``."""
    starts: list[dict[str, float]] = [{}]
    for name, choices in values.items():
        starts = [{**start, name: choice} for start in starts for choice in choices]
    return tuple(starts)
