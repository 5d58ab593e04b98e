"""Rows in this process and their sums; a part of the model runs again only when a parameter on which it depends
changes.
"""

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from damper_estimator.identification.excitations import ExcitationSplit, cycles_of, excitations_in
from damper_estimator.identification.row_sources import Place, Totals
from damper_estimator.identification.rows import Rows, excerpts, motion_moments, split
from damper_estimator.identification.terms import Term
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.numerics import score_covariance, stepped, triangle
from damper_estimator.signals.cycles import Cycle

_KEPT = 4  # settings of the parameters for which a term's columns are remembered


class LocalRows:
    """As ``row_sources.RowSource``, in this process; final.

    Attributes:
        rows: of every measurement; in a joint fit in order of their ``setting``.
        members: of a source of excitations, for each group its excitations, each the positions (k,) of its rows.
    """

    def __init__(self, rows: Sequence[Rows], members: Sequence[Sequence[np.ndarray]] = ()):
        self.rows, self.members = tuple(rows), members

    @property
    def recordings(self) -> tuple[str, ...]:
        """As in the protocol."""
        return tuple(dict.fromkeys(recording.measurement.recording for recording in self.rows))

    @cached_property
    def totals(self) -> Totals:
        """As in the protocol."""
        return Totals(
            samples=sum(len(recording.measurement.kinematics) for recording in self.rows),
            rows=sum(recording.picks.size for recording in self.rows),
            power=float(sum(recording.target @ recording.target for recording in self.rows)),
            moments=tuple(motion_moments(recording.measurement) for recording in self.rows),
        )

    def sums(self, unknowns: Unknowns) -> "LocalSums":
        """As in the protocol."""
        return LocalSums(self, unknowns)

    def excerpts(self, samples: int, total: int) -> "LocalRows":
        """As in the protocol."""
        rows = []
        for recording in self.rows:
            share = samples * len(recording.measurement.kinematics) // total
            rows += [recording.part(part) for part in excerpts(recording.measurement, share)]
        return LocalRows([recording for recording in rows if recording.picks.size])

    def thinned(self) -> "LocalRows":
        """As in the protocol."""
        return LocalRows([part for part in (recording.thinned() for recording in self.rows) if part.picks.size])

    def cycles(self) -> list[tuple[Cycle, ...]]:
        """As in the protocol."""
        return cycles_of(self.rows)

    def excitations(self, given: Mapping[str, Sequence[str]], split: ExcitationSplit) -> "LocalRows":
        """As in the protocol."""
        found = excitations_in(self.rows, given, split)
        return LocalRows(found.rows, found.members)

    def group_sizes(self) -> list[np.ndarray]:
        """As in the protocol."""
        return [np.array([positions.size for positions in group], int) for group in self.members]

    def weighted(self, weights: Sequence[np.ndarray]) -> "LocalRows":
        """As in the protocol."""
        every = np.zeros(sum(recording.picks.size for recording in self.rows))
        for group, counted in zip(self.members, weights, strict=True):
            for positions, weight in zip(group, counted, strict=True):
                every[positions] += weight
        rows = []
        for recording, share in zip(self.rows, split(self.rows, every), strict=True):
            whole = np.zeros(recording.weight.size)
            whole[recording.picks] = recording.weight[recording.picks] * share
            rows.append(recording.weighing(whole))
        return LocalRows(rows, self.members)


class LocalSums:
    """As ``row_sources.RowSums``, of rows in this process; final."""

    def __init__(self, source: LocalRows, unknowns: Unknowns):
        self._source, self._unknowns = source, unknowns
        self._target = np.concatenate([np.zeros(0), *(recording.target for recording in source.rows)])
        self._parts = [_Part(term, k, unknowns.places[k], part) for k, part in self._spans() for term in unknowns.terms]
        self._columns: list[OrderedDict] = [OrderedDict() for _ in self._parts]
        self._near: tuple[bytes, np.ndarray] = (b"", np.zeros((0, 0)))

    def columns(self, searched: np.ndarray) -> np.ndarray:
        """As in the protocol."""
        constant, columns = self._at(searched)
        if not (np.isfinite(constant).all() and np.isfinite(columns).all()):
            return np.full((1, columns.shape[1] + 1), np.nan)
        return self._reduced(np.column_stack([columns, self._target - constant]))

    def linearised(self, place: Place) -> np.ndarray:
        """As in the protocol."""
        return self._reduced(self.near(place))

    def noise(self, place: Place, weights: np.ndarray) -> tuple[np.ndarray, float]:
        """As in the protocol."""
        if not self._source.rows:
            return np.zeros((weights.shape[1], weights.shape[1])), 0.0
        near = self.near(place)
        residuals, scores = split(self._source.rows, near[:, -1]), split(self._source.rows, near[:, :-1] @ weights)
        return score_covariance(residuals, scores, [recording.rate for recording in self._source.rows])

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """As in the protocol."""
        found = []
        for vector in vectors:
            square = self.residual(vector) ** 2
            found.append(
                [np.array([np.mean(square[positions]) for positions in group]) for group in self._source.members]
            )
        return found

    def residual(self, vector: np.ndarray) -> np.ndarray:
        """(m,) rows, modelled less measured, with the values (slots,)."""
        rows = self._source.rows
        models = {k: self._unknowns.model_at(vector, k) for k in {recording.setting for recording in rows}}
        force = [
            recording.of(models[recording.setting].force(recording.measurement.kinematics.block)) for recording in rows
        ]
        return np.concatenate([np.zeros(0), *force]) - self._target

    def near(self, place: Place) -> np.ndarray:
        """(m, q + p + 1) the rows of ``linearised``; the last place is remembered."""
        key = b"|".join(vector.tobytes() for vector in (place.searched, place.solved, place.size))
        if self._near[0] != key:
            constant, columns = self._at(place.searched)
            residual = constant + columns @ place.solved - self._target
            self._near = key, np.column_stack([self._differences(place), columns, residual])
        return self._near[1]

    def _reduced(self, rows: np.ndarray) -> np.ndarray:
        """The triangles of each recording's part of rows (m, k), one below the other."""
        parts = [triangle(part) for part in split(self._source.rows, rows)]
        return np.concatenate([np.zeros((0, rows.shape[1])), *parts])

    def _spans(self) -> list[tuple[int, slice]]:
        """The settings that have rows, with their part of the residual."""
        ends = np.cumsum([recording.picks.size for recording in self._source.rows])
        spans: dict[int, slice] = {}
        for recording, end in zip(self._source.rows, ends.tolist(), strict=True):
            first = spans[recording.setting].start if recording.setting in spans else end - recording.picks.size
            spans[recording.setting] = slice(first, end)
        return list(spans.items())

    def _at(self, searched: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows (m,) without the solved parameters, and per unit of each (m, p)."""
        values = self._values(searched)
        constant, columns = np.zeros(self._target.size), np.zeros((self._target.size, self._unknowns.solved.size))
        for part, (part_constant, part_columns, places) in zip(self._parts, self._parts_at(values), strict=True):
            constant[part.span] += part_constant
            columns[part.span, places] += part_columns
        return constant, columns

    def _values(self, searched: np.ndarray) -> np.ndarray:
        """(slots,) with the start values of the solved parameters."""
        return self._unknowns.vector(searched, self._unknowns.start_vector[self._unknowns.solved])

    def _differences(self, place: Place) -> np.ndarray:
        """(m, q) one-sided differences of the rows by the searched parameters, the linear ones kept constant."""
        unknowns = self._unknowns
        values, start = unknowns.vector(place.searched, place.solved), self._values(place.searched)
        before = [constant + columns @ place.solved[places] for constant, columns, places in self._parts_at(start)]
        runs: list[_Run] = []
        changes: list[tuple[int, int, float]] = []  # part, place in ``searched``, step
        for j, slot in enumerate(unknowns.searched):
            changed, step = stepped(values, slot, place.size[j], unknowns.lower[slot], unknowns.upper[slot])
            for i, part in enumerate(self._parts):
                if slot in part.searched:
                    runs.append((part, changed[part.slots]))
                    changes.append((i, j, step))
        derivative = np.zeros((self._target.size, unknowns.searched.size))
        for (i, j, step), force in zip(changes, self._forces(runs), strict=True):
            derivative[self._parts[i].span, j] += (force - before[i]) / step
        return derivative

    def _parts_at(self, values: np.ndarray) -> "list[_PartRows]":
        """Every part's rows without its solved parameters (r,), per unit of each (r, k), and their places in
        ``solved``; those that are not remembered are run together.
        """
        keys = [values[part.searched].tobytes() for part in self._parts]
        missing = [i for i, key in enumerate(keys) if key not in self._columns[i]]
        plans = [self._plan(self._parts[i], values[self._parts[i].slots]) for i in missing]
        forces = iter(self._forces([run for plan in plans for run in plan.runs]))
        for i, plan in zip(missing, plans, strict=True):
            size = self._parts[i].span.stop - self._parts[i].span.start
            constant = next(forces) if plan.still else np.zeros(size)
            columns = [next(forces) for _ in plan.places]
            self._columns[i][keys[i]] = constant, np.reshape(columns, (len(columns), size)).T, plan.places
        for key, cache in zip(keys, self._columns, strict=True):
            cache.move_to_end(key)
            while len(cache) > _KEPT:
                cache.popitem(last=False)
        return [cache[key] for key, cache in zip(keys, self._columns, strict=True)]

    def _plan(self, part: "_Part", slot_values: np.ndarray) -> "_Plan":
        """What has to be run for a part with the values (s,) of its slots."""
        order = {slot: k for k, slot in enumerate(part.slots.tolist())}
        solved = self._unknowns.solved
        places = [k for k, slot in enumerate(solved.tolist()) if slot in part.linear]
        linear = [order[slot] for slot in part.linear]
        solved_slots = [order[int(solved[k])] for k in places]
        without = slot_values.copy()
        without[solved_slots] = 0.0
        # A term with nothing but solved parameters is zero without them.
        still = not linear or bool(without[linear].any())
        runs: list[_Run] = [(part, without)] if still else []
        for slot in solved_slots:
            unit = without.copy()
            unit[linear] = 0.0
            unit[slot] = 1.0
            runs.append((part, unit))
        return _Plan(runs, still, places)

    def _forces(self, runs: "Sequence[_Run]") -> list[np.ndarray]:
        """Rows of parts of the model, each with the values of its slots; those of one recording are filtered
        together.
        """
        found: list[list[np.ndarray]] = [[] for _ in runs]
        for recording in self._source.rows:
            here = [k for k, (part, _) in enumerate(runs) if part.setting == recording.setting]
            if here:
                block = recording.measurement.kinematics.block
                forces = (part.term.model.force_at(values, block) for part, values in (runs[k] for k in here))
                rows = recording.of_columns(forces)
                for k, column in zip(here, rows.T, strict=True):
                    found[k].append(column)
        return [np.concatenate(columns) for columns in found]


class _Part:
    """One term of the model over the rows of one setting.

    Attributes:
        span: of the residual.
        slots: positions of the term's slots in the problem's.
        searched: those on which it depends nonlinearly.
        linear: those in which it is linear.
    """

    def __init__(self, term: Term, setting: int, places: np.ndarray, span: slice):
        """``places``: positions of the setting's values, by position in ``model.slots``."""
        self.term, self.setting, self.span = term, setting, span
        self.slots = places[list(term.slots)]
        self.searched = places[list(term.searched)]
        self.linear = tuple(places[list(term.linear)].tolist())


_Run = tuple[_Part, np.ndarray]  # with the values of its slots
_PartRows = tuple[np.ndarray, np.ndarray, list[int]]


class _Plan(NamedTuple):
    """What has to be run for a part: the part without its solved parameters if it is ``still`` a force then, and with
    one of each alone, whose ``places`` in ``solved`` follow.
    """

    runs: list[_Run]
    still: bool
    places: list[int]
