"""Splits recordings into excitations and attributes them to groups, for identification with several objectives.

An excitation is a run of cycles of one group that are alike in frequency and peak velocity, such as one sine
of a test series. Irregular motion (random, road) has no such runs: there, all of a recording's cycles of one
group are one excitation. Groups are formed from the recordings' velocities and frequencies
(``signals.grouping``) unless they are given. Long excitations are cut, because a few thousand samples
are enough for an evolution.

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

SAMPLES = 8000  # about, in total
_LEAST = 500  # samples per excitation
_ALIKE = 0.15  # of the run's first cycle's frequency and peak velocity
_RUN = 3  # cycles
_LEAD_IN = 0.2  # s before a run, in which filter and model settle


@dataclass(frozen=True)
class Excitations:
    """The excitations that the objectives judge.

    Attributes:
        rows: of all excitations, one after the other.
        groups: names of the objectives.
        members: for each group its excitations, each the positions (k,) of its samples in all rows together.
    """

    rows: tuple[Rows, ...]
    groups: tuple[str, ...]
    members: tuple[tuple[np.ndarray, ...], ...]


@dataclass(frozen=True)
class ExcitationSplit:
    """How recordings are split, the same for all of them.

    Attributes:
        limits: of velocity and frequency, between the groups.
        names: of the groups that the limits form, in order.
        budget: samples per excitation.
    """

    limits: GroupLimits
    names: tuple[str, ...]
    budget: int


def excitation_split(cycles: Sequence[Sequence[Cycle]]) -> ExcitationSplit:
    """The split by the ranges that all recordings' cycles cover together."""
    limits = group_limits(cycle for recorded in cycles for cycle in recorded)
    count = sum(max(len(_runs(recorded, limits)), 1) for recorded in cycles)
    names = group_names(limits.group(cycle) for recorded in cycles for cycle in recorded)
    return ExcitationSplit(limits, names, max(_LEAST, SAMPLES // max(count, 1)))


def cycles_of(rows: Sequence[Rows]) -> list[tuple[Cycle, ...]]:
    """Whole judged cycles of each recording."""
    return [tuple(find_cycles(recording.measurement.kinematics, recording.measurement.judged)) for recording in rows]


def groups_with_excitations(
    counts: Sequence[int], groups: Sequence[str], given: Mapping[str, Sequence[str]]
) -> list[int]:
    """The positions of the groups that have excitations.

    Raises:
        InputError: where a given group, or every group, has none.
    """
    kept = [k for k, count in enumerate(counts) if count]
    if not kept or (given and len(kept) < len(given)):
        empty = ", ".join(group for group, count in zip(groups, counts, strict=True) if not count)
        raise InputError(
            f"{empty or 'none of the recordings'}: has no whole cycle that can be judged; record longer, or group "
            "otherwise"
        )
    return kept


def excitations_in(rows: Sequence[Rows], given: Mapping[str, Sequence[str]], split: ExcitationSplit) -> Excitations:
    """The excitations of some of the recordings; groups may be empty.

    Raises:
        InputError: for a recording in no group.
    """
    given_group = _given_groups(rows, given) if given else [None] * len(rows)
    grouped = group_cycles([recording.measurement for recording in rows], split.limits, split.names)
    found: dict[str, dict[tuple[int, int], np.ndarray]] = {name: {} for name in (given or split.names)}
    parts: list[Rows] = []
    for i, recording in enumerate(rows):
        runs = _runs(grouped.cycles[i], split.limits)
        for part, run, members in _parts(recording, grouped, i, runs, split.budget, given_group[i]):
            first = sum(other.picks.size for other in parts)
            for group, positions in members.items():
                before = found[group].get((i, run), positions[:0])
                found[group][i, run] = np.concatenate([before, first + positions])
            parts.append(part)
    members = tuple(tuple(positions for positions in group.values() if positions.size) for group in found.values())
    return Excitations(tuple(parts), tuple(found), members)


def named(recording: str, names: Sequence[str]) -> bool:
    """Whether a recording is among names: its path as given, its file name, or its file name without the extension."""
    path = Path(recording)
    return any(Path(name) == path or name in (path.name, path.stem) for name in names)


def _given_groups(rows: Sequence[Rows], given: Mapping[str, Sequence[str]]) -> list[str]:
    chosen = []
    for recording in rows:
        groups = [group for group, names in given.items() if named(recording.measurement.recording, names)]
        if len(groups) != 1:
            where = "no group" if not groups else f"groups {', '.join(groups)}"
            raise InputError(f"{recording.measurement.recording}: is in {where}; name it in one --group NAME=BAG[,BAG]")
        chosen.append(groups[0])
    return chosen


def _runs(cycles: Sequence[Cycle], limits: GroupLimits) -> list[list[Cycle]]:
    """Runs of cycles alike; none where they are less than half of the recording's cycles."""
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
    recording: Rows, grouped: Grouped, i: int, runs: list[list[Cycle]], budget: int, given: str | None
) -> list[tuple[Rows, int, dict[str, np.ndarray]]]:
    """The pieces of one recording that are run: rows, which run it is, and the positions of the rows by group."""
    pieces = []
    lead = int(_LEAD_IN * recording.measurement.kinematics.rate) + 1
    for number, run in enumerate(runs):
        length = max(budget, run[0].last - run[0].first)
        part = recording.part(slice(max(run[0].first - lead, 0), min(run[-1].last, run[0].first + length)))
        group = given or grouped.limits.group(run[0])
        pieces.append((part, number, {group: np.arange(part.picks.size)}))
    for piece in [] if runs else excerpts(recording.measurement, budget * max(len(grouped.names), 1)):
        part = recording.part(piece)
        label = grouped.labels[i][piece][part.picks]
        every = {given: np.arange(part.picks.size)} if given else {}
        members = every or {name: np.flatnonzero(label == k) for k, name in enumerate(grouped.names)}
        pieces.append((part, 0, members))
    return [piece for piece in pieces if piece[0].picks.size]
