"""Saved cases: recordings and user's model, so that a new diagnosis is judged without another simulation."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

import damper_estimator as de
from damper_estimator.model import DamperModel
from population.measurement_chain import Chain, Samples
from population.user_models import load

RECORDINGS = ("base", "fit", "unseen", "twin")


@dataclass(frozen=True)
class Kept:
    """A case with its user's model; ``facts`` is the truth for its record."""

    facts: dict[str, Any]
    chain: Chain
    recordings: dict[str, tuple[Samples, ...]]
    model: DamperModel


def save(folder: Path, name: str, kept: Kept) -> None:
    """Writes the case to a temporary file and moves it into place."""
    folder.mkdir(parents=True, exist_ok=True)
    arrays = {}
    for role, several in kept.recordings.items():
        for number, samples in enumerate(several):
            for field in fields(samples):
                values = getattr(samples, field.name)
                if isinstance(values, np.ndarray):
                    # Single precision preserves nanometres and millinewtons of a logger's values.
                    kind = float if field.name == "time" else np.float32
                    arrays[f"{role}.{number}.{field.name}"] = values.astype(kind)
    de.save_model(kept.model, folder / f"{name}.yaml")
    names = {role: [samples.name for samples in several] for role, several in kept.recordings.items()}
    content = {"facts": kept.facts, "chain": kept.chain.__dict__, "names": names}
    (folder / f"{name}.json").write_text(json.dumps(content))
    partial = folder / f"{name}.part.npz"
    np.savez(partial, **arrays)
    partial.rename(folder / f"{name}.npz")


def saved(folder: Path, name: str) -> Kept | None:
    """The case, if it was saved before."""
    place = folder / f"{name}.npz"
    if not place.exists():
        return None
    content = json.loads((folder / f"{name}.json").read_text())
    with np.load(place) as arrays:
        recordings = {role: _samples(arrays, role, content["names"][role]) for role in RECORDINGS}
    return Kept(content["facts"], Chain(**content["chain"]), recordings, load(folder / f"{name}.yaml"))


def _samples(arrays: Any, role: str, names: Sequence[str]) -> tuple[Samples, ...]:
    """The recordings of a role, in order. Their names matter: a model remembers which ones it was identified on."""
    by_number: dict[int, dict[str, np.ndarray]] = {}
    for key in arrays.files:
        saved_role, number, field = key.split(".")
        if saved_role == role:
            by_number.setdefault(int(number), {})[field] = arrays[key].astype(float)
    return tuple(
        Samples(**{"name": names[number], "temperature": None, "current": None, **by_number[number]})
        for number in sorted(by_number)
    )
