"""The faults of each round, drawn from only the seed and the round's number, so that they are reproducible."""

from collections.abc import Sequence

import numpy as np
from soak_faults import Fault, Kind
from soak_plant import NAMES

TOGETHER = 0.25  # share of rounds with two faults


class Rounds:
    """All kinds in repeatedly shuffled order; final.

    Attributes:
        number: of the next round.
    """

    def __init__(self, kinds: Sequence[Kind], seed: int, first: int) -> None:
        self._kinds, self._seed, self.number = list(kinds), seed, first

    def next(self, now: float, is_fused: bool, may_restart: bool) -> list[Fault]:
        """The faults of the next round; none if the kind is not applicable now.

        Args:
            now: s, when they begin.
            is_fused: whether accelerometers are used.
            may_restart: whether the process can end.
        """
        if not self._kinds:
            return []
        random = np.random.default_rng([self._seed, self.number])
        cycle, place = divmod(self.number, len(self._kinds))
        order = np.random.default_rng([self._seed, 7, cycle]).permutation(len(self._kinds))
        chosen = [self._kinds[order[place]]]
        others = [kind for kind in self._kinds if kind is not chosen[0] and not kind.is_alone]
        if random.random() < TOGETHER and others and not chosen[0].is_alone:
            chosen.append(others[random.integers(len(others))])
        self.number += 1
        faults = []
        for kind in chosen:
            count = random.integers(1, len(NAMES) + 1)
            dampers = sorted(random.choice(len(NAMES), count, replace=False).tolist())
            fault = Fault(kind, random, dampers, now + random.uniform(*kind.seconds), now)
            if (is_fused or not kind.is_fused) and (may_restart or not kind.is_end):
                faults.append(fault)
        return faults
