"""Which samples a filter can use: the one rule for stamps and values, live and offline.

A stamp that is equal to or older than the last accepted one is dropped; a step back or forward of more than
``max_gap`` resets the state and the sample is a new start; a value that is not finite, or absurd (1e6 m and more would
lead to infinities in the filter), is dropped.
"""

from dataclasses import dataclass, fields

import numpy as np

from damper_estimator.compiled import compiled

ACCEPTED, START, GAP, STEP_BACK, DUPLICATE, INVERSION, NON_FINITE = range(7)
DEFAULT_MAX_GAP = 0.1  # s
ABSURD = 1e6  # m


@compiled
def judge(stamp, value, max_gap, state, verdict, dt):
    """Judges a block of samples in arrival order; a block of one is the live case.

    Args:
        stamp: (n,) int64 ns.
        value: (n,) raw values.
        max_gap: int64 ns.
        state: (2,) int64, whether a sample was accepted and the stamp of the last one; kept from block to block.
        verdict: (n,) int64 output, one of the constants above.
        dt: (n,) output, s since the last accepted sample; 0 if the state is reset, undefined if it is dropped.
    """
    for i in range(stamp.size):
        step = stamp[i] - state[1]
        dt[i] = 0.0
        if not abs(value[i]) < ABSURD:  # also true of NaN
            verdict[i] = NON_FINITE
            continue
        if state[0] == 0:
            verdict[i] = START
        elif step < -max_gap:
            verdict[i] = STEP_BACK
        elif step == 0:
            verdict[i] = DUPLICATE
            continue
        elif step < 0:
            verdict[i] = INVERSION
            continue
        elif step > max_gap:
            verdict[i] = GAP
        else:
            verdict[i] = ACCEPTED
            dt[i] = step / 1e9
        state[0] = 1
        state[1] = stamp[i]


@dataclass(frozen=True)
class Counts:
    """Number of samples, and of those that were dropped or reset the state."""

    samples: int = 0
    starts: int = 0
    gaps: int = 0
    steps_back: int = 0
    duplicates: int = 0
    inversions: int = 0
    non_finite: int = 0

    @classmethod
    def of(cls, verdict: np.ndarray) -> "Counts":
        """Counts the verdicts of a block."""
        tally = np.bincount(verdict, minlength=7)
        return cls(int(verdict.size), *(int(tally[code]) for code in range(START, NON_FINITE + 1)))

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))

    @property
    def dropped(self) -> int:
        """Samples without an estimate."""
        return self.duplicates + self.inversions + self.non_finite


class Admission:
    """Keeps the rule's state from block to block."""

    def __init__(self, max_gap: float = DEFAULT_MAX_GAP):
        """``max_gap`` in seconds."""
        self._max_gap = round(max_gap * 1e9)
        self._state = np.zeros(2, np.int64)

    def block(self, stamp: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Verdicts (n,) int64 and steps (n,) s of the next samples: ``stamp`` (n,) int64 ns, ``value`` (n,)."""
        verdict = np.empty(stamp.size, np.int64)
        dt = np.empty(stamp.size)
        judge(stamp, value, self._max_gap, self._state, verdict, dt)
        return verdict, dt

    def reset(self) -> None:
        """Forgets the last sample: the next one is a new start."""
        self._state[:] = 0
