"""The unknowns of a fit: which numbers are identified, their positions and bounds, and which are solved for."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.identification.terms import terms
from damper_estimator.model import DamperModel, Slot


@dataclass(frozen=True)
class Settings:
    """The parameters that differ between the recordings of a joint fit.

    Attributes:
        names: of the settings.
        each: positions in ``model.slots`` of the parameters that have a separate value in each setting.
    """

    names: tuple[str, ...]
    each: frozenset[int]


class Unknowns:
    """A model's free parameters; classes that hold the data of the identification inherit from it.

    Attributes:
        model: with the start values.
        settings: of a joint fit, None for another.
        slots: the model's, and for a joint fit one per setting of those that differ.
        places: (settings, model slots) int, positions in ``slots`` of each setting's values.
        free: positions in ``slots`` of all that is identified.
        searched, solved: those of ``free`` that are searched, and solved for.
        lower, upper: (slots,) bounds of all slots.
        start_vector: (slots,) the model's values.
        terms: the model's terms, whose forces add up to its force.
        given_free, given_slots: as given.
    """

    def __init__(
        self,
        model: DamperModel,
        free: Sequence[int],
        settings: Settings | None = None,
        slots: Sequence[Slot] | None = None,
    ):
        """``free`` and ``slots`` as in ``Problem``."""
        self.model, self.settings = model, settings
        self.given_slots = tuple(slots or model.slots)
        self.slots, self.places = _laid_out(self.given_slots, settings)
        self.free = tuple(dict.fromkeys(self.places[:, list(free)].T.ravel().tolist()))
        self.given_free = tuple(free)
        self.lower = np.array([slot.parameter.lower for slot in self.slots])
        self.upper = np.array([slot.parameter.upper for slot in self.slots])
        self.terms = terms(model)
        linear = {int(place) for term in self.terms for slot in term.linear for place in self.places[:, slot]}
        self.searched = np.array([slot for slot in self.free if slot not in linear], int)
        self.solved = np.array([slot for slot in self.free if slot in linear], int)
        self.start_vector = np.array([slot.value for slot in self.slots])

    @property
    def start(self) -> np.ndarray:
        """(q,) the model's values of the searched parameters, between their bounds."""
        return self.clipped(self.start_vector[self.searched])

    def clipped(self, searched: np.ndarray) -> np.ndarray:
        """(q,) between the bounds."""
        return np.clip(searched, self.lower[self.searched], self.upper[self.searched])

    def vector(self, searched: np.ndarray, solved: np.ndarray) -> np.ndarray:
        """(slots,) values of all slots."""
        values = self.start_vector.copy()
        values[self.searched], values[self.solved] = searched, solved
        return values

    def model_at(self, vector: np.ndarray, setting: int = 0) -> DamperModel:
        """The model with the values (slots,) of one setting."""
        return self.model.with_vector(vector[self.places[setting]])


def _laid_out(given: tuple[Slot, ...], settings: Settings | None) -> tuple[tuple[Slot, ...], np.ndarray]:
    """The slots of a problem, and (settings, model slots) int the positions of each setting's values."""
    if settings is None:
        return given, np.arange(len(given))[None, :]
    slots: list[Slot] = []
    places = np.zeros((len(settings.names), len(given)), int)
    for position, slot in enumerate(given):
        if position in settings.each:
            places[:, position] = len(slots) + np.arange(len(settings.names))
            slots += [replace(slot, address=f"{slot.address}@{name}") for name in settings.names]
        else:
            places[:, position] = len(slots)
            slots.append(slot)
    return tuple(slots), places
