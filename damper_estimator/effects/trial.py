"""How an effect is tried on a recording: where the search for its parameters begins and what is physical there.

Lengths, speeds and forces of dampers differ by orders of magnitude, and shapes without limits impersonate each other
(long pre-sliding friction is a spring, an end stop at mid-stroke is gas): an effect that stands for a phenomenon says
what it may be on the ranges that a recording drives.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

Number = float | tuple[float, ...]


class Untestable(Exception):
    """An effect cannot be tried on a recording; the message says what is missing, in a few words."""


@dataclass(frozen=True)
class Ranges:
    """What recordings of a damper drive; SI units.

    Attributes:
        compression, extension: smallest and largest displacement, less the outermost thousandth, m.
        speed: 99.5 % of the absolute velocities are below it, m/s.
        acceleration: the same, m/s^2.
        force: rms about the mean, N.
        seconds: judged time of the shortest recording.
        command, temperature: lowest and highest (A, deg C); None where not recorded.
    """

    compression: float
    extension: float
    speed: float
    acceleration: float
    force: float
    seconds: float
    command: tuple[float, float] | None = None
    temperature: tuple[float, float] | None = None

    @property
    def stroke(self) -> float:
        """Driven stroke, m."""
        return self.extension - self.compression

    @property
    def middle(self) -> float:
        """Middle of the driven stroke, m."""
        return 0.5 * (self.extension + self.compression)


@dataclass(frozen=True)
class Trial:
    """One way to try an effect.

    Attributes:
        values: settings and start values by name; what is left out takes the effect's default.
        limits: lowest and highest physical value of parameters by name, narrower than their bounds.
        starts: further start values of parameters by name; the best start is gone on with.
    """

    values: Mapping[str, Number] = field(default_factory=dict)
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    starts: tuple[Mapping[str, float], ...] = ()


Try = Callable[[Ranges], Trial]

_STANDING = 0.05  # of the largest command: a smaller change is a command that stands still


def changing_command(ranges: Ranges) -> tuple[float, float]:
    """Lowest and highest command (A).

    Raises:
        Untestable: without a command, or where it stands still: a channel that does not vary explains nothing.
    """
    if ranges.command is None:
        raise Untestable("no command was recorded")
    low, high = ranges.command
    if high - low <= _STANDING * max(abs(low), abs(high)):
        raise Untestable("the command did not change")
    return low, high


_LEAST_CHANGE = 2.0  # K


def changing_temperature(ranges: Ranges) -> tuple[float, float]:
    """Lowest and highest temperature (deg C).

    Raises:
        Untestable: without a temperature, or where it changed by less than 2 K.
    """
    if ranges.temperature is None:
        raise Untestable("no temperature was recorded")
    low, high = ranges.temperature
    if high - low < _LEAST_CHANGE:
        raise Untestable(f"the temperature changed by {high - low:.2g} K only")
    return low, high


def ordinary(ranges: Ranges) -> Trial:
    """From the effect's defaults, between its bounds."""
    return Trial()


def spread(**values: tuple[float, ...]) -> tuple[dict[str, float], ...]:
    """Start values as all combinations: ``spread(delay=(1e-3, 5e-3), gain=(0.5,))``."""
    starts: list[dict[str, float]] = [{}]
    for name, choices in values.items():
        starts = [{**start, name: choice} for start in starts for choice in choices]
    return tuple(starts)
