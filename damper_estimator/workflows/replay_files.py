"""Replays recordings of any length from file to file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.recordings import Bag, BagWriter, open_bag
from damper_estimator.signals import DEFAULT_MAX_GAP, SignalMap, signals_for
from damper_estimator.workflows.arrivals import BagArrivals, Chunk
from damper_estimator.workflows.model_arguments import ModelLike, models_for
from damper_estimator.workflows.replay_line import LineOutput, ReplayCounts, ReplayLine, write_output

_BATCH = 65536
_LONG = 1_000_000  # messages from which progress is reported


@dataclass(frozen=True)
class ReplaySetup:
    """Inputs of a replay: signals and model of each damper, the gap in s that resets, and the window in s."""

    chosen: SignalMap
    models: Mapping[str, DamperModel]
    max_gap: float = DEFAULT_MAX_GAP
    window: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True)
class ReplayOptions:
    """Options of a replay to a file: dampers (empty for all), window in s (None: open), and the gap that resets, s."""

    dampers: Sequence[str] = ()
    start: float | None = None
    stop: float | None = None
    max_gap: float = DEFAULT_MAX_GAP


def replay_to(
    path: Path,
    model: ModelLike,
    output: Path,
    signal_map: SignalMap,
    options: ReplayOptions,
    progress: Callable[[str], None],
) -> dict[str, ReplayCounts]:
    """Replays a recording of any length into another one: unchanged inputs with estimates and residuals added.

    Args:
        progress: receives warnings about a filter other than that of the fit, and progress of long recordings.

    Returns:
        the counts of each damper's samples.

    Raises:
        InputError: as ``replay``, for an output that is the recording itself, and if it cannot be written.
    """
    _check_output(path, output)
    with open_bag(path) as bag:
        whole = signals_for(bag, signal_map)
        for name in options.dampers:
            signals_for(bag, whole, name)
        chosen = only_dampers(whole, options.dampers or whole.dampers)
        models = models_for(model, chosen.dampers)
        _report_cutoffs(models, chosen.cutoff, progress)
        window = (-np.inf if options.start is None else options.start, np.inf if options.stop is None else options.stop)
        with BagWriter(output) as writer:
            return replay_bag(bag, ReplaySetup(chosen, models, options.max_gap, window), writer, progress).tallies


def replay_bag(
    bag: Bag, setup: ReplaySetup, writer: BagWriter, progress: Callable[[str], None] | None = None, size: int = _BATCH
) -> ReplayLine:
    """Writes inputs, estimates and residuals of an opened recording, at most ``size`` messages at a time."""

    def write(chunk: Chunk, output: LineOutput) -> None:
        if chunk.batch is not None:
            writer.write_batch(chunk.batch)
        write_output(writer, chunk, output)

    return run(bag, setup, write, progress, size)


def run(
    bag: Bag,
    setup: ReplaySetup,
    take: Callable[[Chunk, LineOutput], None],
    progress: Callable[[str], None] | None = None,
    size: int = _BATCH,
) -> ReplayLine:
    """Runs the line over an opened recording; ``take`` receives each chunk and its output.

    Raises:
        InputError: for missing channels, and for a model that cannot be deployed.
    """
    arrivals = BagArrivals(bag, setup.chosen, setup.window)
    line, seen = ReplayLine(setup.models, setup.chosen, setup.max_gap, arrivals.measured), 0
    for chunk in arrivals.chunks(size):
        take(chunk, line.take(chunk))
        seen += 0 if chunk.batch is None else len(chunk.batch)
        if progress is not None and arrivals.messages > _LONG:
            progress(f"replayed {seen} of {arrivals.messages} messages")
    arrivals.check({name: tally.counts.samples for name, tally in line.tallies.items()})
    return line


def only_dampers(signal_map: SignalMap, names: Sequence[str] | Mapping[str, object]) -> SignalMap:
    """The map with the entries of these dampers only."""
    return replace(signal_map, dampers={name: signals for name, signals in signal_map.dampers.items() if name in names})


def _check_output(path: Path, output: Path) -> None:
    source, target = path.resolve(), output.resolve()
    if target == source or source in target.parents or (path.exists() and output.exists() and path.samefile(output)):
        raise InputError(f"{output}: is the recording itself; choose another name with -o")


def _report_cutoffs(models: Mapping[str, DamperModel], cutoff: float, progress: Callable[[str], None]) -> None:
    for name, model in models.items():
        fitted: Any = model.fit.get("cutoff")
        if fitted is not None and float(fitted or 0.0) != cutoff:
            progress(
                f"{name}: model {model.name} was fitted with the filter at {fitted or 'none'} Hz, but it is "
                f"at {cutoff or 'none'} Hz here"
            )
