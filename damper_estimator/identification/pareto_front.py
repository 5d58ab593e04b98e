"""A Pareto front: solutions of which none is better than another in every objective, and choices from it.

    knee:            the point that is nearest to the best of every objective, logarithms scaled by their range;
                     where there are any, among those that are worse than the start in no group
    regimes (4.3):   mean and spread of every parameter over the solutions that are best for one group

Source: Gao et al., eqs. (9), (10), section 4.3.
"""

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError

BEST = 15  # solutions per group whose parameters are summarised, as in the source
_PREFIX = "e_"


@dataclass(frozen=True)
class Front:
    """Solutions in order of the first objective.

    Attributes:
        names: addresses of the parameters.
        groups: names of the objectives.
        values: (k, p) of the parameters.
        objectives: (k, g) mean over the group's excitations of the squared error relative to that of the start.
        picked: row that became the model; -1 before the choice.
        excitations: how many each group has.
    """

    names: tuple[str, ...]
    groups: tuple[str, ...]
    values: np.ndarray
    objectives: np.ndarray
    picked: int = -1
    excitations: tuple[int, ...] = ()

    def row(self, pick: str) -> int:
        """The row that a choice names: ``knee``, the best for a group, or a number from 0.

        Raises:
            InputError: with all that may be chosen.
        """
        if pick in self.groups:
            return int(np.argmin(self.objectives[:, self.groups.index(pick)]))
        if pick == "knee":
            # Objectives are ratios, so their logarithms are compared.
            level = np.log(np.maximum(self.objectives, np.finfo(float).tiny))
            low, high = level.min(axis=0), level.max(axis=0)
            scaled = np.linalg.norm((level - low) / np.where(high > low, high - low, 1.0), axis=1)
            worse = (self.objectives > 1.0).any(axis=1)
            return int(np.argmin(scaled + np.where(worse, np.inf, 0.0) if not worse.all() else scaled))
        if pick.isdecimal() and int(pick) < len(self.values):
            return int(pick)
        last = len(self.values) - 1
        raise InputError(
            f"pick {pick!r}: is none of knee, {', '.join(self.groups)}, and no point 0 to {last} of the front"
        )

    def regimes(self, count: int = BEST) -> dict[str, dict[str, dict[str, float]]]:
        """By group and parameter: ``mean``, ``stddev``, ``min`` and ``max`` over the ``count`` best for the group."""
        found = {}
        for k, group in enumerate(self.groups):
            best = self.values[np.argsort(self.objectives[:, k], kind="stable")[:count]]
            rows = zip(self.names, best.mean(axis=0), best.std(axis=0), best.min(axis=0), best.max(axis=0), strict=True)
            found[group] = {n: {"mean": m, "stddev": s, "min": a, "max": b} for n, m, s, a, b in rows}
        return found

    def as_csv(self) -> str:
        """One line per point: its number, the objectives as ``e_GROUP``, the parameters by address."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["point", *(_PREFIX + group for group in self.groups), *self.names])
        for k, (errors, values) in enumerate(zip(self.objectives.tolist(), self.values.tolist(), strict=True)):
            writer.writerow([k, *errors, *values])
        return text.getvalue()


def non_dominated(objectives: np.ndarray) -> np.ndarray:
    """(k,) bool: rows of (k, g) than which no other is better in one objective and as good in all."""
    one, other = objectives[:, None, :], objectives[None]
    better = (other <= one).all(axis=2) & (other < one).any(axis=2)
    return ~better.any(axis=1)


def load_front(path: Path) -> Front:
    """The front that ``as_csv`` wrote.

    Raises:
        InputError: where the file is missing or holds something else.
    """
    try:
        head, *rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
        table = np.array(rows, float)
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise InputError(f"{path}: is no front; name the .front.csv that fit --method nsga2 wrote") from error
    count = sum(name.startswith(_PREFIX) for name in head)
    if head[:1] != ["point"] or not count or table.ndim != 2 or table.shape[1] != len(head):
        raise InputError(f"{path}: is no front; name the .front.csv that fit --method nsga2 wrote")
    groups = tuple(name.removeprefix(_PREFIX) for name in head[1 : 1 + count])
    return Front(tuple(head[1 + count :]), groups, table[:, 1 + count :], table[:, 1 : 1 + count])
