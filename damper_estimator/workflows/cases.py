"""Cases for ``diagnose``, ``improve`` and ``plan``: the model and recordings of each damper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement, SignalMap
from damper_estimator.workflows.model_arguments import ModelLike, model_name, models_for
from damper_estimator.workflows.recording import Recording, checked

Progress = Callable[[str, float], None]
"""Receives the current activity and the completed share of the work, 0 to 1."""

MODES = ("both", "kept", "refit")


@dataclass(frozen=True)
class Case:
    """One damper: the user's model and the recordings; without ``unseen`` 40 % of each are reserved."""

    damper: str
    model: DamperModel
    fit: tuple[Measurement, ...]
    unseen: tuple[Measurement, ...]


@dataclass(frozen=True)
class DiagnosisCases:
    """The cases of all dampers.

    Attributes:
        cases: one per damper.
        request: the inputs, for JSON: ``bags``, ``validate``, ``model``.
        signal_map: with which the recordings were read, with an entry for every damper in them.
        notes: omissions, one sentence each.
    """

    cases: tuple[Case, ...]
    request: dict[str, object]
    signal_map: SignalMap
    notes: tuple[str, ...]


def diagnosis_cases(recording: Recording, model: ModelLike, validate: Recording | None, use: str) -> DiagnosisCases:
    """The cases of all dampers that have a measured force.

    Args:
        validate: recordings to judge on; a damper in none of them is judged on 40 % of its own recordings.
        use: what requires the force, for errors.

    Raises:
        InputError: if a model or a measured force is missing.
    """
    measured = checked(recording).with_force(use)
    models = models_for(model, measured.dampers)
    later = None if validate is None else checked(validate).with_force(use)
    unseen = {} if later is None else later.measurements
    notes = [*measured.notes, *(() if later is None else later.notes)]
    notes += [
        f"{damper}: not in the recordings to judge on; 40 % of its own recordings are reserved for that"
        for damper in measured.dampers
        if validate is not None and damper not in unseen
    ]
    cases = tuple(
        Case(name, models[name], measurements, unseen.get(name, ()))
        for name, measurements in measured.measurements.items()
    )
    request = {
        "bags": list(recording.names),
        "validate": [] if validate is None else list(validate.names),
        "model": model_name(model),
    }
    return DiagnosisCases(cases, request, recording.signal_map, tuple(notes))


def check_mode(mode: str) -> None:
    """Checks the mode of a diagnosis.

    Raises:
        InputError: if it does not exist.
    """
    if mode not in MODES:
        raise InputError(f"mode {mode!r}: does not exist; choose one of {', '.join(MODES)}")


def no_progress(text: str, share: float) -> None:
    """Discards progress."""
