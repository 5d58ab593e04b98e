"""What ``diagnose`` and ``improve`` share: recordings to find on and to judge on, and how candidates are judged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement, SignalMap
from damper_estimator.workflows.models import ModelLike, model_name, models_for
from damper_estimator.workflows.recording import Recording, checked

Tell = Callable[[str, float], None]
"""Receives what goes on and its share of the work, 0 to 1."""

MODES = ("both", "kept", "refit")


@dataclass(frozen=True)
class Case:
    """One damper: the user's model and the recordings; without ``unseen`` the last 40 % of each are kept back."""

    damper: str
    model: DamperModel
    fit: tuple[Measurement, ...]
    unseen: tuple[Measurement, ...]


@dataclass(frozen=True)
class Judging:
    """What is to be judged, damper by damper.

    Attributes:
        cases: one per damper.
        asked: for the record: ``bags``, ``validate``, ``model``.
        signal_map: by which the recordings were read, with an entry for every damper in them.
        notes: what was left out, one sentence each.
    """

    cases: tuple[Case, ...]
    asked: dict[str, object]
    signal_map: SignalMap
    notes: tuple[str, ...]


def judging_of(recording: Recording, model: ModelLike, validate: Recording | None, use: str) -> Judging:
    """The cases of all dampers that have a measured force.

    Args:
        validate: recordings to judge on; a damper that is in none of them is judged on the last 40 % of its own.
        use: what needs the force, for errors.

    Raises:
        InputError: where a model or a measured force is missing.
    """
    found = checked(recording).with_force(use)
    models = models_for(model, found.dampers)
    later = None if validate is None else checked(validate).with_force(use)
    unseen = {} if later is None else later.measurements
    notes = [*found.notes, *(() if later is None else later.notes)]
    notes += [
        f"{damper}: in none of the recordings to judge on; the last 40 % of its own are kept back for that"
        for damper in found.dampers
        if validate is not None and damper not in unseen
    ]
    cases = tuple(Case(name, models[name], own, unseen.get(name, ())) for name, own in found.measurements.items())
    asked = {
        "bags": list(recording.names),
        "validate": [] if validate is None else list(validate.names),
        "model": model_name(model),
    }
    return Judging(cases, asked, recording.signal_map, tuple(notes))


def check_mode(mode: str) -> None:
    """Refuses a way of judging that does not exist.

    Raises:
        InputError: one line.
    """
    if mode not in MODES:
        raise InputError(f"mode {mode!r}: is not a way of judging; choose {', '.join(MODES)}")


def silent(text: str, share: float) -> None:
    """Tells nobody."""
