"""Classifies a mean loop as one of seven pattern types by measures that can be verified in the F-v diagram.

| type | yields | force lags at low speed | at high speed |
| --- | --- | --- | --- |
| 0 | no | no | no |
| 1 | yes | no | no |
| 2 | yes | no | rising speed has more force (yield beyond restoring point) |
| 3 | yes | yes | no |
| 4 | yes, and flat beyond an early knee | no | no |
| 5 | yes | yes | yes |
| 6 | any | no, or it leads | falling speed has more force (types 2 and 3 inverted) |

An elliptic hysteresis over the whole speed range is that of a spring or a mass: every structure has these terms, so
it is reported but excluded from the type. The paper states no thresholds; those below are chosen here. Source:
Lozoya-Santos et al., section 2.1 (Table 5 swaps the restoring points' columns; by its text and by geometry B is in
compression, F in rebound).
"""

from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.characterization.halves import GRID, Half, halves, hinge, offset
from damper_estimator.characterization.loops import Loop

YIELD_RATIO = 2.0  # slope before the knee over slope beyond it, at least; the paper's for asymmetric dampers
YIELD_LOSS = 0.10  # force lost to the knee relative to a straight line, over the half's force at peak speed, at least
FLAT_RISE, FLAT_KNEE = (
    0.15,
    0.35,
)  # a flat half: rise beyond the knee over peak force, and relative speed of the knee, at most
LOW, HIGH = 0.04, 0.03  # area between the branches at low and at high speed over peak force times peak speed, at least
ELLIPSE = 0.95  # share of the hysteresis' energy that an ellipse explains
SYMMETRIC = 0.10  # rms difference of both directions over their rms force, at most


@dataclass(frozen=True)
class HalfMeasures:
    """Measures of a half's diagram.

    Attributes:
        yields, flat: the two verdicts.
        knee_velocity: m/s, absolute.
        high_damping, low_damping: N s/m, slopes of the mean curve before and beyond the knee.
        ratio: high over low; infinite if the low one is not positive.
        rise: force gained beyond the knee over force at peak speed.
        hysteresis_low, hysteresis_high: area between falling and rising branch below and beyond their knees, over
            peak force times peak speed; negative: more force while the speed rises.
    """

    yields: bool
    flat: bool
    knee_velocity: float
    high_damping: float
    low_damping: float
    ratio: float
    rise: float
    hysteresis_low: float
    hysteresis_high: float


@dataclass(frozen=True)
class Pattern:
    """A loop's type with its measures.

    Attributes:
        type: 0 to 6.
        rebound, compression: measures of both directions.
        hysteresis_low, hysteresis_high: means of both directions; positive: the force lags.
        ellipse: share of the hysteresis' energy that a spring or mass explains; 0 where there is hardly any.
        stiffness: N/m of that spring; negative: a mass.
        asymmetry: rms difference of both directions over their rms.
        symmetric: verdict.
        offset: N, at reversal.
        because: the reasoning as text.
    """

    type: int
    rebound: HalfMeasures
    compression: HalfMeasures
    hysteresis_low: float
    hysteresis_high: float
    ellipse: float
    stiffness: float
    asymmetry: float
    symmetric: bool
    offset: float
    because: str


def classify(loop: Loop) -> Pattern:
    """The pattern type of a mean loop."""
    both = halves(loop)
    scale = 0.5 * float(both[0].middle[-1] + both[1].middle[-1]) or 1.0
    share, size = _ellipse(both)
    elliptic = share >= ELLIPSE and abs(size) > LOW * abs(scale)
    flattened = tuple(_without_ellipse(half, size) for half in both) if elliptic else both
    rebound, compression = (_measures(half, scale) for half in flattened)
    low, high = (
        0.5 * (getattr(rebound, name) + getattr(compression, name)) for name in ("hysteresis_low", "hysteresis_high")
    )
    difference, mean = both[0].middle - both[1].middle, 0.5 * (both[0].middle + both[1].middle)
    asymmetry = float(np.sqrt(np.mean(difference**2) / max(float(np.mean(mean**2)), 1e-300)))
    kind, why = _verdict(rebound, compression, low, high)
    stiffness = size / (2.0 * loop.amplitude)
    if elliptic:
        mass = -stiffness / (2.0 * np.pi * loop.frequency) ** 2
        element = f"a spring of {stiffness:.3g} N/m" if size > 0.0 else f"a mass of {mass:.3g} kg"
        why += f"; an elliptic hysteresis like that of {element} is excluded (k_p x + m_D a describes it)"
    return Pattern(
        kind, rebound, compression, low, high, share, stiffness, asymmetry, asymmetry <= SYMMETRIC, offset(loop), why
    )


def _ellipse(both: tuple[Half, Half]) -> tuple[float, float]:
    """Share of the hysteresis' energy that h = size sqrt(1 - u^2) explains in both halves, and size in N."""
    shape = np.tile(np.sqrt(1.0 - GRID**2), 2)
    h = np.concatenate([half.hysteresis for half in both])
    size = float(shape @ h / (shape @ shape))
    energy = float(h @ h)
    return (max(0.0, 1.0 - float(np.sum((h - size * shape) ** 2)) / energy) if energy > 0.0 else 0.0), size


def _without_ellipse(half: Half, size: float) -> Half:
    part = 0.5 * size * np.sqrt(1.0 - GRID**2)
    rising, falling = half.rising + part, half.falling - part
    return replace(half, rising=rising, falling=falling, before=hinge(rising), after=hinge(falling))


def yields(half: Half) -> bool:
    """Whether the slope falls to half or less at a knee that is relevant at peak speed."""
    mean, top = half.mean, abs(float(half.middle[-1])) or 1.0
    loss = (mean.high - mean.low) * (1.0 - mean.knee)
    return mean.high > 0.0 and mean.low * YIELD_RATIO <= mean.high and loss >= YIELD_LOSS * top


def _measures(half: Half, scale: float) -> HalfMeasures:
    mean, top = half.mean, float(half.middle[-1])
    bends = yields(half)
    areas = half.hysteresis / (scale * (GRID.size - 1))
    split = _split(half) if bends else 0.5
    rise = (top - mean.at_knee) / top if top else 0.0
    return HalfMeasures(
        yields=bends,
        flat=bends and rise <= FLAT_RISE and mean.knee <= FLAT_KNEE,
        knee_velocity=mean.knee * half.peak_velocity,
        high_damping=mean.high / half.peak_velocity,
        low_damping=mean.low / half.peak_velocity,
        ratio=mean.high / mean.low if mean.low > 0.0 else float("inf"),
        rise=float(rise),
        hysteresis_low=float(areas[GRID <= split].sum()),
        hysteresis_high=float(areas[GRID > split].sum()),
    )


def _split(half: Half) -> float:
    """End of low speed: the range between the knees belongs to the side with the wider gap between the branches."""
    first, last = sorted((half.before.knee, half.after.knee))
    low, high = (abs(float(half.hysteresis[inside].mean())) for inside in (GRID <= first, GRID > last))
    return last if low >= high else first


def _verdict(rebound: HalfMeasures, compression: HalfMeasures, low: float, high: float) -> tuple[int, str]:
    numbers = (
        f"hysteresis {100 * low:+.1f} % of peak force times peak speed at low speed, {100 * high:+.1f} % at high speed"
    )
    if low < -LOW or (high > HIGH and low <= 0.5 * LOW):
        return 6, f"{numbers}: the restoring point lies above the yield point (types 2 and 3 inverted)"
    if abs(high) > HIGH and low > (0.5 * LOW if high > 0.0 else LOW):
        return 5, f"{numbers}: at low and at high speed (types 2 and 3 mixed)"
    if low > LOW:
        return 3, f"{numbers}: the force lags only at low speed"
    if high < -HIGH:
        return 2, f"{numbers}: more force while the speed rises, only at high speed"
    if not (rebound.yields or compression.yields):
        return 0, f"{numbers}; no knee: one slope up to peak speed"
    speeds = [
        f"{half.knee_velocity:.3g} m/s in {name}"
        for half, name in ((rebound, "rebound"), (compression, "compression"))
        if half.yields
    ]
    knees = f"{numbers}; knee at {' and '.join(speeds)}"
    if all(half.flat for half in (rebound, compression) if half.yields):
        return 4, f"{knees}, flat beyond it"
    return 1, f"{knees}, a lower slope beyond it"
