"""Rows in this process, and what they add up to; every part of the model is run again only when a parameter changes on
which it depends.
"""

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from damper_estimator.identification.excitations import Split, cycles_of, excitations_in
from damper_estimator.identification.rows import Rows, excerpts, motion_moments, split
from damper_estimator.identification.sources import Place, Totals
from damper_estimator.identification.terms import Term
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.numerics import score_covariance, stepped, triangle
from damper_estimator.signals.cycles import Cycle

_KEPT = 4  # settings of the parameters for which a term's columns are remembered


class LocalRows:
    """As ``sources.RowSource``, in this process; final.

    Attributes:
        rows: of every measurement; in a joint fit in order of their ``setting``.
        members: of a source of excitations, for each group its excitations, each the positions (k,) of its rows.
    """

    def __init__(self, rows: Sequence[Rows], members: Sequence[Sequence[np.ndarray]] = ()):
        self.rows, self.members = tuple(rows), members

    @property
    def recordings(self) -> tuple[str, ...]:
        """As in the protocol."""
        return tuple(dict.fromkeys(own.measurement.recording for own in self.rows))

    @cached_property
    def totals(self) -> Totals:
        """As in the protocol."""
        return Totals(
            samples=sum(len(own.measurement.kinematics) for own in self.rows),
            rows=sum(own.picks.size for own in self.rows),
            power=float(sum(own.target @ own.target for own in self.rows)),
            moments=tuple(motion_moments(own.measurement) for own in self.rows),
        )

    def sums(self, unknowns: Unknowns) -> "LocalSums":
        """As in the protocol."""
        return LocalSums(self, unknowns)

    def excerpts(self, samples: int, total: int) -> "LocalRows":
        """As in the protocol."""
        rows = []
        for own in self.rows:
            share = samples * len(own.measurement.kinematics) // total
            rows += [own.part(part) for part in excerpts(own.measurement, share)]
        return LocalRows([own for own in rows if own.picks.size])

    def thinned(self) -> "LocalRows":
        """As in the protocol."""
        return LocalRows([part for part in (own.thinned() for own in self.rows) if part.picks.size])

    def cycles(self) -> list[tuple[Cycle, ...]]:
        """As in the protocol."""
        return cycles_of(self.rows)

    def excitations(self, given: Mapping[str, Sequence[str]], split: Split) -> "LocalRows":
        """As in the protocol."""
        found = excitations_in(self.rows, given, split)
        return LocalRows(found.rows, found.members)

    def group_sizes(self) -> list[np.ndarray]:
        """As in the protocol."""
        return [np.array([own.size for own in group], int) for group in self.members]

    def weighted(self, weights: Sequence[np.ndarray]) -> "LocalRows":
        """As in the protocol."""
        every = np.zeros(sum(own.picks.size for own in self.rows))
        for group, counted in zip(self.members, weights, strict=True):
            for positions, weight in zip(group, counted, strict=True):
                every[positions] += weight
        rows = []
        for own, share in zip(self.rows, split(self.rows, every), strict=True):
            whole = np.zeros(own.weight.size)
            whole[own.picks] = own.weight[own.picks] * share
            rows.append(own.weighing(whole))
        return LocalRows(rows, self.members)


class LocalSums:
    """As ``sources.RowSums``, of rows in this process; final."""

    def __init__(self, source: LocalRows, unknowns: Unknowns):
        self._source, self._unknowns = source, unknowns
        self._target = np.concatenate([np.zeros(0), *(own.target for own in source.rows)])
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
        return score_covariance(residuals, scores, [own.rate for own in self._source.rows])

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """As in the protocol."""
        found = []
        for vector in vectors:
            square = self.residual(vector) ** 2
            found.append([np.array([np.mean(square[own]) for own in group]) for group in self._source.members])
        return found

    def residual(self, vector: np.ndarray) -> np.ndarray:
        """(m,) rows, modelled less measured, with the values (slots,)."""
        rows = self._source.rows
        models = {k: self._unknowns.model_at(vector, k) for k in {own.setting for own in rows}}
        force = [own.of(models[own.setting].force(own.measurement.kinematics.block)) for own in rows]
        return np.concatenate([np.zeros(0), *force]) - self._target

    def near(self, place: Place) -> np.ndarray:
        """(m, q + p + 1) the rows of ``linearised``; the last place is remembered."""
        key = b"|".join(own.tobytes() for own in (place.searched, place.solved, place.size))
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
        ends = np.cumsum([own.picks.size for own in self._source.rows])
        spans: dict[int, slice] = {}
        for own, end in zip(self._source.rows, ends.tolist(), strict=True):
            first = spans[own.setting].start if own.setting in spans else end - own.picks.size
            spans[own.setting] = slice(first, end)
        return list(spans.items())

    def _at(self, searched: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows (m,) without the solved parameters, and per unit of each (m, p)."""
        values = self._values(searched)
        constant, columns = np.zeros(self._target.size), np.zeros((self._target.size, self._unknowns.solved.size))
        for i, part in enumerate(self._parts):
            own_constant, own_columns, places = self._part_at(i, part, values)
            constant[part.span] += own_constant
            columns[part.span, places] += own_columns
        return constant, columns

    def _values(self, searched: np.ndarray) -> np.ndarray:
        """(slots,) with the start values of the solved parameters."""
        return self._unknowns.vector(searched, self._unknowns.start_vector[self._unknowns.solved])

    def _differences(self, place: Place) -> np.ndarray:
        """(m, q) one-sided differences of the rows by the searched parameters, the linear ones held."""
        unknowns = self._unknowns
        values, start = unknowns.vector(place.searched, place.solved), self._values(place.searched)
        before = []
        for i, part in enumerate(self._parts):
            constant, columns, places = self._part_at(i, part, start)
            before.append(constant + columns @ place.solved[places])
        derivative = np.zeros((self._target.size, unknowns.searched.size))
        for j, slot in enumerate(unknowns.searched):
            changed, step = stepped(values, slot, place.size[j], unknowns.lower[slot], unknowns.upper[slot])
            for part, force in zip(self._parts, before, strict=True):
                if slot in part.searched:
                    derivative[part.span, j] += (self._run(part, changed[part.slots]) - force) / step
        return derivative

    def _part_at(self, i: int, part: "_Part", values: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[int]]:
        """A part's rows without its solved parameters (r,), per unit of each (r, k), and their places in ``solved``."""
        key = values[part.searched].tobytes()
        cache = self._columns[i]
        if key in cache:
            cache.move_to_end(key)
            return cache[key]
        own = values[part.slots]
        order = {slot: k for k, slot in enumerate(part.slots.tolist())}
        solved = self._unknowns.solved
        places = [k for k, slot in enumerate(solved.tolist()) if slot in part.linear]
        linear = [order[slot] for slot in part.linear]
        mine = [order[int(solved[k])] for k in places]
        own[mine] = 0.0
        size = part.span.stop - part.span.start
        # A term with nothing but solved parameters is zero without them.
        still = not linear or own[linear].any()
        constant = self._run(part, own) if still else np.zeros(size)
        columns = np.empty((size, len(mine)))
        own[linear] = 0.0
        for k, slot in enumerate(mine):
            own[slot] = 1.0
            columns[:, k] = self._run(part, own)
            own[slot] = 0.0
        cache[key] = constant, columns, places
        if len(cache) > _KEPT:
            cache.popitem(last=False)
        return cache[key]

    def _run(self, part: "_Part", values: np.ndarray) -> np.ndarray:
        """Rows of one part's force with the values of its slots."""
        model = part.term.model.with_vector(values)
        rows = [own for own in self._source.rows if own.setting == part.setting]
        return np.concatenate([own.of(model.force(own.measurement.kinematics.block)) for own in rows])


class _Part:
    """One term of the model over the rows of one setting.

    Attributes:
        span: of the residual.
        slots: positions in the problem's slots of the term's.
        searched: those on which it depends otherwise than linearly.
        linear: those in which it is linear.
    """

    def __init__(self, term: Term, setting: int, places: np.ndarray, span: slice):
        """``places``: where the setting's values stand, by position in ``model.slots``."""
        self.term, self.setting, self.span = term, setting, span
        self.slots = places[list(term.slots)]
        self.searched = places[list(term.searched)]
        self.linear = tuple(places[list(term.linear)].tolist())
