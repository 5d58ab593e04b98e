"""Recordings replayed from file to file, of any length."""

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
from damper_estimator.workflows.models import ModelLike, models_for
from damper_estimator.workflows.replay_line import Answer, ReplayLine, Tally, write_answer

_BATCH = 65536
_TOLD_FROM = 1_000_000  # messages, of recordings whose progress is told


@dataclass(frozen=True)
class ReplaySetup:
    """What is replayed: signals and model of each damper, the gap in s that resets, and the window in s."""

    chosen: SignalMap
    models: Mapping[str, DamperModel]
    max_gap: float = DEFAULT_MAX_GAP
    window: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True)
class ReplayOptions:
    """How to replay to a file: dampers (empty for all), s from the start (None: all), and the gap that resets, s."""

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
    tell: Callable[[str], None],
) -> dict[str, Tally]:
    """Replays a recording of any length into another one: inputs as they were, estimates and residuals beside them.

    Args:
        tell: receives what should be known: a filter other than that of the fit, progress of long recordings.

    Returns:
        what became of each damper's samples.

    Raises:
        InputError: as ``replay``, for an output that is the recording itself, and where it cannot be written.
    """
    _refuse_input_as_output(path, output)
    with open_bag(path) as bag:
        whole = signals_for(bag, signal_map)
        for name in options.dampers:
            signals_for(bag, whole, name)
        chosen = only_dampers(whole, options.dampers or whole.dampers)
        models = models_for(model, chosen.dampers)
        _tell_cutoffs(models, chosen.cutoff, tell)
        window = (-np.inf if options.start is None else options.start, np.inf if options.stop is None else options.stop)
        with BagWriter(output) as writer:
            return replay_bag(bag, ReplaySetup(chosen, models, options.max_gap, window), writer, tell).tallies


def replay_bag(
    bag: Bag, setup: ReplaySetup, writer: BagWriter, tell: Callable[[str], None] | None = None, size: int = _BATCH
) -> ReplayLine:
    """Writes inputs, estimates and residuals of an opened recording, at most ``size`` messages at a time."""

    def write(chunk: Chunk, answer: Answer) -> None:
        if chunk.batch is not None:
            writer.write_batch(chunk.batch)
        write_answer(writer, chunk, answer)

    return run(bag, setup, write, tell, size)


def run(
    bag: Bag,
    setup: ReplaySetup,
    take: Callable[[Chunk, Answer], None],
    tell: Callable[[str], None] | None = None,
    size: int = _BATCH,
) -> ReplayLine:
    """Runs the line over an opened recording; ``take`` is given each chunk and its answer.

    Raises:
        InputError: for channels that the bag lacks, and for a model that cannot be deployed.
    """
    arrivals = BagArrivals(bag, setup.chosen, setup.window)
    line, seen = ReplayLine(setup.models, setup.chosen, setup.max_gap, arrivals.measured), 0
    for chunk in arrivals.chunks(size):
        take(chunk, line.take(chunk))
        seen += 0 if chunk.batch is None else len(chunk.batch)
        if tell is not None and arrivals.messages > _TOLD_FROM:
            tell(f"replayed {seen} of {arrivals.messages} messages")
    arrivals.check({name: tally.counts.samples for name, tally in line.tallies.items()})
    return line


def only_dampers(signal_map: SignalMap, names: Sequence[str] | Mapping[str, object]) -> SignalMap:
    """The map with the entries of these dampers alone."""
    return replace(signal_map, dampers={name: own for name, own in signal_map.dampers.items() if name in names})


def _refuse_input_as_output(path: Path, output: Path) -> None:
    here, there = path.resolve(), output.resolve()
    if there == here or here in there.parents or (path.exists() and output.exists() and path.samefile(output)):
        raise InputError(f"{output}: is the recording itself; give another name with -o")


def _tell_cutoffs(models: Mapping[str, DamperModel], cutoff: float, tell: Callable[[str], None]) -> None:
    for name, model in models.items():
        fitted: Any = model.fit.get("cutoff")
        if fitted is not None and float(fitted or 0.0) != cutoff:
            tell(
                f"{name}: model {model.name} was fitted with the filter at {fitted or 'none'} Hz, here it is "
                f"at {cutoff or 'none'} Hz"
            )
