"""The best identified model of real recordings, and that model without one of its effects that matters."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

import damper_estimator as de
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel
from damper_estimator.model.element import labels
from population.user_models import error

TRIED = (
    "mr_damper_on_mount", "mr_damper_with_play", "lozoya_santos_inertial_simple_symmetric",
    "lozoya_santos_stiff_simple_symmetric", "kwok", "bouc_wen", "dahl", "carrera_akutain",
)  # fmt: skip
MATTERS = 1.15
"""Factor by which the unseen error grows without an effect that matters."""

A_MODEL_STILL = 0.6
"""Of the force's rms: a model with a larger error lacks the damper, not an effect."""


@dataclass(frozen=True)
class Ablated:
    """A model without one of its effects, identified again; ``error`` is that of the whole model, N rms unseen."""

    model: DamperModel
    effect: str
    phenomenon: str
    error: float


class NothingMatters(Exception):
    """No tried model has an effect that matters on these recordings."""


def ranked(seen: de.Recording, unseen: de.Recording, names: Sequence[str] = TRIED) -> list[tuple[float, DamperModel]]:
    """Identified library models and their unseen errors in N rms, best first, without those that cannot be
    identified."""
    found = []
    for name in names:
        try:
            model = de.fit(seen, name).model
        except de.InputError:
            continue
        found.append((error(model, unseen), model))
    return sorted(found, key=lambda pair: pair[0])


def ablated(
    ranking: Sequence[tuple[float, DamperModel]], seen: de.Recording, unseen: de.Recording, rng: np.random.Generator
) -> Ablated:
    """The best model with an effect that matters, without one such effect, drawn at random.

    Raises:
        NothingMatters: if there is none.
    """
    force = unseen.measurements[unseen.dampers[0]]
    spread = float(np.concatenate([candidate.in_band(candidate.force)[candidate.judged] for candidate in force]).std())
    for whole, model in ranking[:3]:
        candidates = [
            candidate for candidate in _without_one(model, seen) if _matters(candidate, unseen, whole, spread)
        ]
        if candidates:
            effect, less = candidates[rng.integers(len(candidates))]
            return Ablated(less, effect, find_effect(effect).phenomenon, whole)
    raise NothingMatters("no effect of the three best models matters on these recordings")


def _without_one(model: DamperModel, seen: de.Recording) -> Iterator[tuple[str, DamperModel]]:
    for label, element in labels(model.effects):
        if element.effect.phenomenon:
            try:
                yield element.effect.name, de.fit(seen, model.without(label)).model
            except de.InputError:
                continue


def _matters(candidate: tuple[str, DamperModel], unseen: de.Recording, whole: float, spread: float) -> bool:
    return MATTERS * whole <= error(candidate[1], unseen) <= A_MODEL_STILL * spread
