"""Splits recordings into excitations and attributes them to groups, for identification with several objectives.

An excitation is a run of cycles of one group that are alike in frequency and peak velocity, such as one sine
of a test series. Irregular motion (random, road) has no such runs: there, all of a recording's cycles of one
group are one excitation. Groups are formed from the recordings' own velocities and frequencies
(``signals.grouping``) unless they are given. Long excitations are cut, for a few thousand samples tell what
an evolution needs.

Source: Gao et al., section 3.2.1, Table 1.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.identification.rows import Rows, excerpts
from damper_estimator.signals.cycles import Cycle, find_cycles
from damper_estimator.signals.grouping import Grouped, GroupLimits, group_cycles, group_limits, group_names

SAMPLES = 8000  # in all, about
_LEAST = 500  # samples per excitation
_ALIKE = 0.15  # of the run's first cycle's frequency and peak velocity
_RUN = 3  # cycles
_LEAD_IN = 0.2  # s before a run, in which filter and model settle


@dataclass(frozen=True)
class Excitations:
    """What the objectives judge.

    Attributes:
        rows: of all excitations, one after the other.
        groups: names of the objectives.
        members: for each group its excitations, each the positions (k,) of its samples in all rows together.
    """

    rows: tuple[Rows, ...]
    groups: tuple[str, ...]
    members: tuple[tuple[np.ndarray, ...], ...]


@dataclass(frozen=True)
class Split:
    """How recordings are split, the same for all of them.

    Attributes:
        limits: of velocity and frequency, between the groups.
        names: of the groups that the limits form, in order.
        budget: samples per excitation.
    """

    limits: GroupLimits
    names: tuple[str, ...]
    budget: int


def split_of(cycles: Sequence[Sequence[Cycle]]) -> Split:
    """The split by the ranges that all recordings' cycles cover together."""
    limits = group_limits(cycle for own in cycles for cycle in own)
    count = sum(max(len(_runs(own, limits)), 1) for own in cycles)
    names = group_names(limits.group(cycle) for own in cycles for cycle in own)
    return Split(limits, names, max(_LEAST, SAMPLES // max(count, 1)))


def cycles_of(rows: Sequence[Rows]) -> list[tuple[Cycle, ...]]:
    """Whole judged cycles of each."""
    return [tuple(find_cycles(own.measurement.kinematics, own.measurement.judged)) for own in rows]


def filled(counts: Sequence[int], groups: Sequence[str], given: Mapping[str, Sequence[str]]) -> list[int]:
    """The groups that have excitations, by position.

    Raises:
        InputError: where a given group has none, or none has.
    """
    kept = [k for k, count in enumerate(counts) if count]
    if not kept or (given and len(kept) < len(given)):
        empty = ", ".join(group for group, count in zip(groups, counts, strict=True) if not count)
        raise InputError(
            f"{empty or 'none of the recordings'}: holds no whole cycle that can be judged; record longer, or group "
            "otherwise"
        )
    return kept


def excitations_in(rows: Sequence[Rows], given: Mapping[str, Sequence[str]], split: Split) -> Excitations:
    """The excitations of some of the recordings; groups may be empty.

    Raises:
        InputError: for a recording in no group.
    """
    own_group = _given_groups(rows, given) if given else [None] * len(rows)
    grouped = group_cycles([own.measurement for own in rows], split.limits, split.names)
    found: dict[str, dict[tuple[int, int], np.ndarray]] = {name: {} for name in (given or split.names)}
    parts: list[Rows] = []
    for i, own in enumerate(rows):
        runs = _runs(grouped.cycles[i], split.limits)
        for part, run, members in _parts(own, grouped, i, runs, split.budget, own_group[i]):
            first = sum(other.picks.size for other in parts)
            for group, positions in members.items():
                before = found[group].get((i, run), positions[:0])
                found[group][i, run] = np.concatenate([before, first + positions])
            parts.append(part)
    members = tuple(tuple(own for own in group.values() if own.size) for group in found.values())
    return Excitations(tuple(parts), tuple(found), members)


def named(recording: str, names: Sequence[str]) -> bool:
    """Whether a recording is among names: its path as given, its file name, or that without its ending."""
    path = Path(recording)
    return any(Path(name) == path or name in (path.name, path.stem) for name in names)


def _given_groups(rows: Sequence[Rows], given: Mapping[str, Sequence[str]]) -> list[str]:
    chosen = []
    for own in rows:
        groups = [group for group, names in given.items() if named(own.measurement.recording, names)]
        if len(groups) != 1:
            where = "no group" if not groups else f"groups {', '.join(groups)}"
            raise InputError(f"{own.measurement.recording}: is in {where}; name it in one --group NAME=BAG[,BAG]")
        chosen.append(groups[0])
    return chosen


def _runs(cycles: Sequence[Cycle], limits: GroupLimits) -> list[list[Cycle]]:
    """Runs of cycles alike; none where they are the lesser part of the recording's cycles."""
    runs: list[list[Cycle]] = []
    for cycle in cycles:
        if runs and cycle.first - runs[-1][-1].last <= 1 and _alike(runs[-1][0], cycle, limits):
            runs[-1].append(cycle)
        else:
            runs.append([cycle])
    steady = [run for run in runs if len(run) >= _RUN]
    return steady if 2 * sum(map(len, steady)) >= len(cycles) else []


def _alike(first: Cycle, cycle: Cycle, limits: GroupLimits) -> bool:
    return (
        abs(cycle.frequency - first.frequency) <= _ALIKE * first.frequency
        and abs(cycle.peak_velocity - first.peak_velocity) <= _ALIKE * first.peak_velocity
        and limits.group(cycle) == limits.group(first)
    )


def _parts(
    own: Rows, grouped: Grouped, i: int, runs: list[list[Cycle]], budget: int, given: str | None
) -> list[tuple[Rows, int, dict[str, np.ndarray]]]:
    """The pieces of one recording that are run: rows, which run it is, and the positions of the rows by group."""
    pieces = []
    lead = int(_LEAD_IN * own.measurement.kinematics.rate) + 1
    for number, run in enumerate(runs):
        length = max(budget, run[0].last - run[0].first)
        part = own.part(slice(max(run[0].first - lead, 0), min(run[-1].last, run[0].first + length)))
        group = given or grouped.limits.group(run[0])
        pieces.append((part, number, {group: np.arange(part.picks.size)}))
    for piece in [] if runs else excerpts(own.measurement, budget * max(len(grouped.names), 1)):
        part = own.part(piece)
        label = grouped.labels[i][piece][part.picks]
        every = {given: np.arange(part.picks.size)} if given else {}
        members = every or {name: np.flatnonzero(label == k) for k, name in enumerate(grouped.names)}
        pieces.append((part, 0, members))
    return [piece for piece in pieces if piece[0].picks.size]
