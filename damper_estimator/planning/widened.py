"""What would separate where nothing within the limits does: each limit widened alone, and what the effects ask for."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from damper_estimator.diagnosis import Explanations
from damper_estimator.effects.discovery import all_effects
from damper_estimator.planning.limits import Limits
from damper_estimator.planning.rig import Rig

_WIDER = 2.0
_FASTEST = 25.0  # Hz
_BETTER = 0.15  # what a wider limit must add to the probability of a right decision to be named


@dataclass(frozen=True)
class Widened:
    """A rig with one limit widened, in words."""

    words: str
    rig: Rig
    limits: Limits


def widenings(
    rig: Rig, limits: Limits, found: Explanations, chance: Callable[[Widened], float], now: float
) -> tuple[str, ...]:
    """In words: wider limits that would let a test separate, then the effects' own ways.

    Args:
        chance: probability of a right decision on a widened rig.
        now: the same within the limits.
    """
    sentences = []
    for wide in _each(rig, limits):
        probability = chance(wide)
        if probability >= now + _BETTER:
            sentences.append(f"{wide.words}: {100.0 * probability:.0f} % probability of a right decision")
    tests = {all_effects()[hypothesis.effect].separate: None for hypothesis in found.fitted}
    sentences += [one for one in tests if not any(other.startswith(one) and other != one for other in tests)]
    return tuple(one for one in sentences if one)


def _each(rig: Rig, limits: Limits) -> Iterator[Widened]:
    if rig.kind != "played":
        played = replace(rig, kind="played", amplitude=0.0, manoeuvres=())
        yield Widened("a rig that plays drive files", played, replace(limits, amplitude=0.0))
        return
    centre, half = 0.5 * (limits.low + limits.high), 0.5 * _WIDER * (limits.high - limits.low)
    wide = replace(limits, low=centre - half, high=centre + half)
    yield Widened(f"{1e3 * 2.0 * half:.0f} mm of stroke", rig, wide)
    faster = replace(limits, speed=_WIDER * limits.speed, acceleration=_WIDER * limits.acceleration)
    yield Widened(f"{faster.speed:.2g} m/s and {faster.acceleration:.3g} m/s^2", rig, faster)
    if limits.frequency[1] < 0.99 * min(_FASTEST, 0.25 * limits.rate):
        top = min(_FASTEST, 0.25 * limits.rate)
        yield Widened(f"frequencies up to {top:g} Hz", rig, replace(limits, frequency=(limits.frequency[0], top)))
    if not limits.mean_positions:
        yield Widened("other mean positions", rig, replace(limits, mean_positions=True))
