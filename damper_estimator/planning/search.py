"""Chooses steps: the one that raises the criterion most per second, again and again, then exchanges.

A test that is to be diagnosed drives all of its steps in each half: a diagnosis judges on the last part of a recording
what it fitted to the first one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Score = Callable[[np.ndarray], float]
Report = Callable[[str, float], None]

_EXCHANGES = 2  # passes over the chosen steps
_MOST_EXCHANGED = 24  # chosen steps up to which exchanges pay
_STALLED = 1e-6
_MOST = 6  # times a step may be driven
_KEPT = 40  # of the steps are gone on with, those that help most at one time or another


@dataclass(frozen=True)
class Choice:
    """The steps of one part by position, in the order in which they were chosen, and the number of such parts."""

    order: tuple[int, ...]
    parts: int

    def counts(self, steps: int, first: int | None = None) -> np.ndarray:
        """(steps,) how often each is driven in all parts, of the ``first`` of the order; all without."""
        return float(self.parts) * np.bincount(np.array(self.order[:first], int), minlength=steps)


def chosen(
    score: Score,
    seconds: np.ndarray,
    most: float,
    enough: Callable[[np.ndarray], bool],
    report: Report,
    *,
    parts: int = 2,
    first: Sequence[int] = (),
    different: int = 0,
) -> Choice:
    """Steps for a test of at most ``most`` seconds.

    Args:
        score: of counts (s,); larger is better.
        seconds: (s,) of each step.
        enough: whether counts need nothing more; the search then ends early.
        parts: of the test, in each of which every chosen step is driven.
        first: steps to begin with.
        different: so many steps are all different, before any of them is driven again and before the search may end.
    """
    seconds, order = parts * seconds, list(first)
    counts = Choice(tuple(order), parts).counts(seconds.size)
    spent, now = float(counts @ seconds) / parts, score(counts)
    alive = np.arange(seconds.size)
    while True:
        fits = alive[(spent + seconds[alive] <= most + 1e-9) & (counts[alive] < _MOST)]
        is_narrow = np.count_nonzero(counts) < different and bool((counts[fits] == 0).any())
        if is_narrow:
            fits = fits[counts[fits] == 0]
        if not fits.size or (order and enough(counts) and not is_narrow):
            break
        gains = np.array([score(_more(counts, i, parts)) - now for i in fits]) / seconds[fits]
        best = int(fits[int(np.argmax(gains))])
        if gains.max() <= _STALLED / most and not is_narrow:
            break
        if len(order) in (2, 6) and fits.size > _KEPT:  # what helps nothing early seldom helps late
            alive = np.union1d(fits[np.argsort(-gains, kind="stable")[:_KEPT]], np.unique(order))
        counts, spent = _more(counts, best, parts), spent + seconds[best]
        order.append(best)
        now = score(counts)
        report("choosing steps", min(spent / most, 1.0))
    if len(order) <= _MOST_EXCHANGED:
        order = _exchanged(order, score, seconds, most, alive, parts, different)
    return Choice(tuple(order), parts)


def repeated_one(score: Score, seconds: np.ndarray, most: float, *, parts: int = 2) -> tuple[int, ...]:
    """The one step that is worth most if it is driven as often as it may be; empty where none fits.

    A search that begins with nothing finds no way where every short test is worse than none: it dilutes what the old
    recordings say and adds too little.
    """
    often = np.minimum(np.floor(most / (parts * seconds) + 1e-9), _MOST).astype(int)
    fits = np.flatnonzero(often)
    if not fits.size:
        return ()
    scores = [score(parts * often[i] * (np.arange(seconds.size) == i)) for i in fits]
    best = int(fits[int(np.argmax(scores))])
    return (best,) * int(often[best])


def _exchanged(
    order: Sequence[int],
    score: Score,
    seconds: np.ndarray,
    most: float,
    alive: np.ndarray,
    parts: int,
    different: int,
) -> list[int]:
    """Each chosen step against every other one that fits into the time (Fedorov's exchange)."""
    order = list(order)
    counts = Choice(tuple(order), parts).counts(seconds.size)
    now, different = score(counts), min(different, np.count_nonzero(counts))
    for _ in range(_EXCHANGES):
        before = now
        for place, step in enumerate(order):
            less = counts.copy()
            less[step] -= parts
            spent = float(less @ seconds) / parts
            # An exchange may not make the test longer: the shortest one counts as well.
            fits = [i for i in alive if seconds[i] <= seconds[step] + 1e-9 and spent + seconds[i] <= most + 1e-9]
            fits = [i for i in fits if np.count_nonzero(less) + (less[i] == 0) >= different]
            scores = [score(_more(less, i, parts)) for i in fits]
            if scores and max(scores) > now + _STALLED:
                order[place] = int(fits[int(np.argmax(scores))])
                counts, now = _more(less, order[place], parts), max(scores)
        if now <= before + _STALLED:
            break
    return order


def _more(counts: np.ndarray, step: int, parts: int) -> np.ndarray:
    more = counts.copy()
    more[step] += parts
    return more
