"""Starts for models with compliances: what a search finds with every compliance rigid.

Behind a compliance no parameter can be solved for, so each point of a curve is searched, and points spread at random
are far from any answer. Without the compliance the same curve is solved for. Its values, and those of all other
parameters found with it, are a start for the whole model, with the compliance as it was given.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from damper_estimator.effects.discovery import PATH
from damper_estimator.identification.problem import Problem
from damper_estimator.identification.start_points import candidates
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import forces_of, walk

FACTORS = (1.0, 4.0, 0.25)
"""By which the compliances' own parameters are multiplied for a start each."""

_AT_BOUND = 1e-6  # of the distance of the bounds
_FAR = 10.0  # times the model's value


def with_rigid_starts(
    problem: Problem,
    sketch: Problem,
    starts: np.ndarray,
    seed: int,
    search: Callable[[Problem, np.ndarray, np.ndarray], np.ndarray],
) -> np.ndarray:
    """The starts (s, q), and behind the first one those with rigid compliances; as given if the model has none.

    Args:
        sketch: the same problem on excerpts.
        search: (problem, starts, sizes (q,)) to the best searched values (q,).
    """
    rigid = without_compliances(problem.model)
    if rigid is problem.model or problem.settings is not None or len(starts) < 2:
        return starts
    places = common_slots(problem.model, rigid)
    free = [i for i, place in enumerate(places) if place in problem.free]
    if not free:
        return starts
    slots = [replace(problem.slots[place], address=own.address, entry=own.entry)
             for place, own in zip(places, rigid.slots, strict=True)]  # fmt: skip
    stiff = Problem(rigid, sketch.source, free, slots=slots)
    point = stiff.point(search(stiff, *candidates(stiff, seed)))
    if not np.isfinite(point.cost):
        return starts
    values = problem.start_vector.copy()
    values[places] = _within(stiff, stiff.vector(point.searched, point.solved))
    own = np.setdiff1d(np.arange(values.size), places)
    found = []
    for factor in FACTORS:
        scaled = values.copy()
        scaled[own] *= factor
        found.append(problem.clipped(scaled[problem.searched]))
    return np.vstack([starts[:1], *found, starts[1:]])


def _within(stiff: Problem, found: np.ndarray) -> np.ndarray:
    """Values (slots,), those at a bound or far from the model's replaced by these: they stand in for the compliance."""
    near = np.minimum(found - stiff.lower, stiff.upper - found) > _AT_BOUND * (stiff.upper - stiff.lower)
    given = np.abs(stiff.start_vector)
    near[stiff.searched] &= ((np.abs(found) <= _FAR * given) | (given == 0.0))[stiff.searched]
    return np.where(near, found, stiff.start_vector)


def without_compliances(model: DamperModel) -> DamperModel:
    """The model with what compliances carry in their place; itself if it has none."""
    if not any(element.effect.kind == "series" for element in walk(model.effects)):
        return model
    return replace(model, effects=_carried(model.effects), fixed=(), fit={})


def common_slots(model: DamperModel, rigid: DamperModel) -> list[int]:
    """Position in ``model.slots`` of each slot of the model without its compliances."""
    entries = {id(element.parameters): entry for entry, element in enumerate(walk(model.effects))}
    there = {(slot.entry, slot.parameter.name, slot.index): i for i, slot in enumerate(model.slots)}
    kept = list(walk(rigid.effects))
    return [there[entries[id(kept[slot.entry].parameters)], slot.parameter.name, slot.index] for slot in rigid.slots]


def _carried(elements: tuple[Element, ...]) -> tuple[Element, ...]:
    return tuple(
        Element(PATH, path=_carried(forces_of(element.path, element.effect)))
        if element.effect.kind == "series"
        else replace(element, path=_carried(element.path))
        for element in elements
    )
