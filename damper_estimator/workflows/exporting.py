"""Exporting a model: C for controllers, a functional mock-up unit for simulation."""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import sha256
from os import PathLike
from pathlib import Path

from damper_estimator.codegen import Choices, WrittenC, WrittenFmu, write_c, write_fmu
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, library_models, load_model
from damper_estimator.signals import DamperSignals, SignalMap, load_signal_map
from damper_estimator.workflows.model_arguments import ModelSource

MapLike = str | PathLike[str] | SignalMap


def to_c(
    model: ModelSource,
    folder: str | PathLike[str],
    *,
    name: str = "",
    signals: MapLike | None = None,
    damper: str = "",
    cutoff: float | None = None,
    limits: tuple[float, float] | None = None,
    lead: float = 0.0,
    stale_after: float = 0.1,
    single: bool = False,
) -> WrittenC:
    """Writes a damper's model as ``NAME.h`` and ``NAME.c``: filter, chain, status, and the inverse if it has one.

    Args:
        name: prefix of files and functions; "" for the model's name.
        signals: the map of the vehicle, for filter, fusion, limits and ages; ``damper`` selects one of several.
        cutoff: Hz of the filter, 0 for none; None uses that of the map, else that of the fit, else 60.
        limits: lowest and highest command; None uses those of the map, else those of the fit.
        lead: s that the motion is predicted ahead.
        stale_after: s without a sample after which the status is STALE.
        single: single precision; the result states its error.

    Raises:
        InputError: if the model or the map is unusable, or the folder cannot be written.
    """
    loaded, checksum = _loaded(model)
    choices = Choices(
        name=name, cutoff=cutoff, lead=lead, limits=limits, stale_after=stale_after, single=single, checksum=checksum
    )
    return write_c(loaded, Path(folder), _with_map(choices, signals, damper))


def to_fmu(
    model: ModelSource,
    path: str | PathLike[str],
    *,
    name: str = "",
    version: str = "2.0",
    binary: bool = True,
    signals: MapLike | None = None,
    damper: str = "",
    cutoff: float | None = None,
    limits: tuple[float, float] | None = None,
    lead: float = 0.0,
) -> WrittenFmu:
    """Writes a damper's model as an FMU for co-simulation, with sources and a binary for this platform.

    Args:
        version: of FMI, 2.0 or 3.0.
        binary: False for sources only, which needs no C compiler.
        name, signals, damper, cutoff, limits, lead: as in `to_c`; an FMU has no accelerometer, so no fusion.

    Raises:
        InputError: as `to_c`, and if a binary is requested without a C compiler.
    """
    loaded, checksum = _loaded(model)
    choices = Choices(name=name, cutoff=cutoff, lead=lead, limits=limits, checksum=checksum)
    return write_fmu(loaded, Path(path), _with_map(choices, signals, damper), version, binary)


def _loaded(model: ModelSource) -> tuple[DamperModel, str]:
    """The model, and the checksum of its file; "" if it does not come from a file."""
    if isinstance(model, DamperModel):
        return model, ""
    loaded, path = load_model(model if isinstance(model, str) else Path(model)), Path(model)
    file = path if path.exists() else library_models()[str(model)]
    return loaded, sha256(file.read_bytes()).hexdigest()


def _with_map(choices: Choices, signals: MapLike | None, damper: str) -> Choices:
    """The choices, completed by the signal map."""
    if signals is None:
        return choices
    found = signals if isinstance(signals, SignalMap) else load_signal_map(Path(signals))
    cutoff = found.cutoff if choices.cutoff is None else choices.cutoff
    damper_signals = _of_damper(found.dampers, damper, found.where)
    return choices.with_map(cutoff, found.fusion, damper_signals)


def _of_damper(dampers: Mapping[str, DamperSignals], damper: str, where: str) -> DamperSignals:
    names = [damper] if damper else list(dampers)
    if len(names) != 1 or names[0] not in dampers:
        raise InputError(f"{where}: choose one of its dampers: {', '.join(dampers) or 'it has none'}")
    return dampers[names[0]]
