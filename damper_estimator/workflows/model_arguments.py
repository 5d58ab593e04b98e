"""Resolves a model argument: a library name, a file, a folder, a model, or a mapping of these by damper."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, load_model


class HoldsModels(ABC):
    """A result with a model for each damper. Abstract."""

    @property
    @abstractmethod
    def models(self) -> Mapping[str, DamperModel]:
        """The models by damper; ``compare`` and others accept this mapping, or the result itself."""


ModelSource = str | PathLike[str] | DamperModel
ModelLike = ModelSource | Mapping[str, ModelSource] | HoldsModels
"""A model, the name of one in the library, a model file, a folder with one DAMPER.yaml each, a mapping of these by
damper, or a result with models.
"""


def model_for(model: ModelLike, damper: str) -> DamperModel:
    """The model of one damper.

    Raises:
        InputError: if there is none, or its file is unusable.
    """
    if isinstance(model, DamperModel):
        return model
    if isinstance(model, HoldsModels):
        return model_for(model.models, damper)
    if not isinstance(model, Mapping):
        return load_model(Path(model) if isinstance(model, PathLike) else model, damper)
    if damper not in model:
        raise InputError(f"models: none for damper {damper}; the mapping has {', '.join(model) or 'no damper'}")
    return model_for(model[damper], damper)


def models_for(model: ModelLike, dampers: Iterable[str]) -> dict[str, DamperModel]:
    """The model of each damper.

    Raises:
        InputError: as ``model_for``.
    """
    return {damper: model_for(model, damper) for damper in dampers}


def model_name(model: ModelLike) -> object:
    """A model argument for JSON: its name or path as given, or that of each damper."""
    if isinstance(model, HoldsModels):
        return model_name(model.models)
    if isinstance(model, Mapping):
        return {damper: model_name(entry) for damper, entry in model.items()}
    return model.name if isinstance(model, DamperModel) else str(model)
