"""What a test may do: the rig's limits, narrowed to where the model of the damper means something.

A model says nothing beyond the strokes and speeds that it was identified on, and nobody knows where the damper's stops
are: the recordings' range is the limit unless the rig's file states the damper's travel. Frequency is the rig's alone,
up to the band in which recordings are compared.
"""

from dataclasses import dataclass

from damper_estimator.effects.trial import Ranges
from damper_estimator.errors import InputError
from damper_estimator.planning.rig import Range, Rig

_LEAST_STROKE = 2e-4  # m
_BEYOND = 1.25  # of the recorded speed
_BAND = 0.8  # of the comparison's band


@dataclass(frozen=True)
class Limits:
    """What every instant of a drive obeys; SI units.

    Attributes:
        low, high: m, displacement.
        home: m, where every step begins and ends at rest.
        speed, acceleration, force: largest.
        frequency: Hz.
        rate: Hz, of the drive.
        mean_positions: whether steps may have a mean position other than ``home``.
        amplitude: m, of a crank; else 0.
        temperature, current: levels to choose from; empty where it stays as it is.
    """

    low: float
    high: float
    home: float
    speed: float
    acceleration: float
    force: float
    frequency: Range
    rate: float
    mean_positions: bool = False
    amplitude: float = 0.0
    temperature: tuple[float, ...] = ()
    current: tuple[float, ...] = ()

    def record(self) -> dict[str, object]:
        """For the plan's file, with units in the names."""
        return {
            "displacement_m": [round(self.low, 6), round(self.high, 6)],
            "speed_m_s": round(self.speed, 6),
            "acceleration_m_s2": round(self.acceleration, 6),
            "force_n": round(self.force, 3),
            "frequency_hz": [round(f, 4) for f in self.frequency],
            "rate_hz": self.rate,
            "mean_positions": self.mean_positions,
            "temperature_deg_c": list(self.temperature),
            "current_a": list(self.current),
        }


def limits_of(rig: Rig, ranges: Ranges, band: float) -> Limits:
    """The limits of a test on a rig, of a damper that was driven over ``ranges`` and is compared up to ``band`` Hz.

    Raises:
        InputError: where nothing is left to drive.
    """
    low, high = rig.travel or (ranges.compression, ranges.extension)
    low, high = max(low, rig.displacement[0]), min(high, rig.displacement[1])
    if high - low < _LEAST_STROKE:
        what = "the damper's travel" if rig.travel else "what the recordings drove"
        raise InputError(
            f"rig {rig.name}: displacement {_mm(rig.displacement)} and {what} "
            f"{_mm(rig.travel or (ranges.compression, ranges.extension))} leave no stroke; correct one of them"
        )
    home = min(max(0.0, low), high)
    if home in (low, high) or rig.kind == "crank":
        home = 0.5 * (low + high)
    top = min(rig.frequency[1], _BAND * band) if band > 0.0 else rig.frequency[1]
    if top <= rig.frequency[0]:
        raise InputError(
            f"rig {rig.name}: begins at {rig.frequency[0]:g} Hz, above {top:g} Hz, up to which forces are compared; "
            "raise the band in the signal map"
        )
    speed = min(rig.speed, _BEYOND * ranges.speed)
    found = Limits(
        low, high, home, speed, rig.acceleration, rig.force, (rig.frequency[0], top), rig.rate,
        rig.mean_positions, rig.amplitude if rig.kind == "crank" else 0.0, rig.temperature, rig.current,
    )  # fmt: skip
    if found.amplitude:
        _check_crank(rig, found)
    return found


def _check_crank(rig: Rig, limits: Limits) -> None:
    stroke = 0.5 * (limits.high - limits.low)
    if limits.amplitude > stroke * (1.0 + 1e-9):
        raise InputError(
            f"rig {rig.name}: a crank of {1e3 * limits.amplitude:.3g} mm needs {2e3 * limits.amplitude:.3g} mm of "
            f"stroke, but {2e3 * stroke:.3g} mm are allowed; state the damper's travel or set a shorter crank"
        )
    slowest = 6.2832 * limits.frequency[0] * limits.amplitude
    if slowest > limits.speed:
        raise InputError(
            f"rig {rig.name}: the crank reaches {slowest:.3g} m/s at {limits.frequency[0]:g} Hz, more than the allowed "
            f"{limits.speed:.3g} m/s; set a shorter crank or a lower frequency"
        )


def _mm(ends: Range) -> str:
    return f"{1e3 * ends[0]:.3g} to {1e3 * ends[1]:.3g} mm"
