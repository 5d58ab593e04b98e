"""The judge's records: displacement messages in transit, and the results of each kind of fault."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Sent:
    """One displacement message in transit; lists over the dampers."""

    time: float
    truth: np.ndarray
    undisturbed: np.ndarray
    verdicts: list[str]
    excuses: list[str]
    kinds: tuple[str, ...]
    handed: float


@dataclass
class Tally:
    """The counts of one fault kind."""

    rounds: int = 0
    good: int = 0
    excused: int = 0
    worst: float = 0.0
    worst_excused: float = 0.0
    violations: int = 0
