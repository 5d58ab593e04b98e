"""Runs a model over a recording exactly as the node does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.model import DamperModel
from damper_estimator.recordings import Part, open_bag, write_part
from damper_estimator.signals import DEFAULT_MAX_GAP
from damper_estimator.workflows.arrivals import part_chunk
from damper_estimator.workflows.model_arguments import ModelLike, models_for
from damper_estimator.workflows.recording import Recording, checked, storable
from damper_estimator.workflows.replay_files import ReplayOptions, ReplaySetup, only_dampers, replay_to, run
from damper_estimator.workflows.replay_line import LineOutput, ReplayCounts, ReplayLine
from damper_estimator.workflows.results import Results
from damper_estimator.workflows.tables import data_frame

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class DamperReplayed:
    """One damper.

    Attributes:
        tally: counts of its samples.
        stamp: (n,) int64 ns, of the estimates.
        fields: (n,) by field of damper_msgs/DamperForces: displacement, velocity, force, force_stddev, status, ...
        residual_stamp, residual: (m,) int64 ns and N, model minus measured force; empty if none was measured.
    """

    tally: ReplayCounts
    stamp: np.ndarray
    fields: Mapping[str, np.ndarray]
    residual_stamp: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True, repr=False, eq=False)
class ReplayResults(Results[DamperReplayed]):
    """Estimates as the node would have published them, by damper.

    The properties are those of one damper (``result["front_left"]`` selects one of several).

    Attributes:
        recording, models, max_gap: inputs of the replay.
    """

    recording: Recording
    models: Mapping[str, DamperModel]
    max_gap: float

    @property
    def stamp(self) -> np.ndarray:
        """(n,) int64 ns, stamps of the displacements behind the estimates."""
        return self.only.stamp

    @property
    def time(self) -> np.ndarray:
        """(n,) s since the first estimate."""
        seconds: np.ndarray = (self.stamp - self.stamp[:1]) * 1e-9
        return seconds

    @property
    def force(self) -> np.ndarray:
        """(n,) N, the estimated force."""
        return self.only.fields["force"]

    @property
    def force_stddev(self) -> np.ndarray:
        """(n,) N, standard deviation of the estimate; NaN if the model was not fitted."""
        return self.only.fields["force_stddev"]

    @property
    def status(self) -> np.ndarray:
        """(n,) 0 good, 1 warming up, 2 extrapolating, 3 degraded, 4 stale."""
        return self.only.fields["status"]

    @property
    def residual(self) -> np.ndarray:
        """(m,) N, model minus measured force through the same filter; empty if none was measured."""
        return self.only.residual

    def save(self, path: str | Path) -> Path:
        """Writes estimates: ``.mcap`` together with the inputs, ``.csv`` as a table, ``.json`` the counts only.

        Raises:
            InputError: for another file extension, for several dampers and ``.csv``, and if it cannot be written.
        """
        path = Path(path)
        if path.suffix == ".mcap":
            _save_bag(self, path)
        elif path.suffix == ".csv":
            columns = {"stamp_ns": self.only.stamp, **self.only.fields}
            rows = (",".join(_number(value) for value in row) for row in zip(*columns.values(), strict=True))
            write_text(path, "\n".join([",".join(columns), *rows]) + "\n")
        elif path.suffix == ".json":
            return super().save(path)
        else:
            raise InputError(f"{path}: cannot hold estimates; choose a name ending in .mcap, .csv or .json")
        return path

    def _record(self, result: DamperReplayed) -> dict[str, object]:
        return result.tally.record()

    def _line(self, result: DamperReplayed) -> str:
        rms = result.tally.residual_rms_n
        residual = "" if rms is None else f", residual {rms:.4g} N rms"
        return f"{result.tally.estimates} estimates of {result.tally.counts.samples} samples{residual}"

    def _rows(self, result: DamperReplayed) -> list[dict[str, object]]:
        return [result.tally.record()]

    def to_dataframe(self) -> pandas.DataFrame:
        """A row per estimate: damper, stamp in ns, and the fields of damper_msgs/DamperForces.

        Raises:
            InputError: if pandas is not installed.
        """
        parts = [
            {"damper": np.full(result.stamp.size, damper), "stamp_ns": result.stamp, **result.fields}
            for damper, result in self.by_damper.items()
        ]
        return data_frame({name: np.concatenate([part[name] for part in parts]) for name in parts[0]})

    def _figure(self, result: DamperReplayed) -> Mapping[str, object]:
        from damper_estimator.report import estimates_figure

        begin = result.stamp[0] if result.stamp.size else 0
        times = [(stamp - begin) * 1e-9 for stamp in (result.stamp, result.residual_stamp)]
        return estimates_figure(times[0], result.fields["force"], times[1], result.residual)


def replay(recording: Recording, model: ModelLike, *, max_gap: float = DEFAULT_MAX_GAP) -> ReplayResults:
    """Runs models over a recording as the node does: in order of arrival, slow channels hold their last value.

    Args:
        recording: a single recording; the residual requires a measured force, the estimates do not.
        model: a name of the library, a model file, a folder with one ``DAMPER.yaml`` each, a model, or a mapping of
            these by damper.
        max_gap: a longer gap between stamps resets the state, s.

    Raises:
        InputError: for several recordings, and for a model that is unusable or cannot be deployed.
    """
    sources = checked(recording).sources
    if len(sources) != 1:
        raise InputError(f"replay accepts one recording, but got {', '.join(recording.names)}; read one of them")
    (source,) = sources
    models, chosen = models_for(model, recording.dampers), only_dampers(recording.signal_map, recording.dampers)
    collected = _Collected(recording.dampers)
    if isinstance(source, Part):
        chunk = part_chunk(source, chosen, recording.window)
        line = ReplayLine(models, chosen, max_gap, set(chunk.gauge))
        collected.add(line.take(chunk))
    else:
        setup = ReplaySetup(chosen, models, max_gap, recording.window)
        with open_bag(source) as bag:
            line = run(bag, setup, lambda chunk, output: collected.add(output))
    found = {name: collected.of(name, tally) for name, tally in line.tallies.items()}
    return ReplayResults({"output": None}, found, recording, models, max_gap)


class _Collected:
    """Estimates and residuals of all chunks; final."""

    def __init__(self, dampers: Sequence[str]) -> None:
        self._stamps: dict[str, list[np.ndarray]] = {name: [] for name in dampers}
        self._fields: dict[str, list[Mapping[str, np.ndarray]]] = {name: [] for name in dampers}
        self._residuals: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {name: [] for name in dampers}

    def add(self, output: LineOutput) -> None:
        for name, result in output.estimates.items():
            self._stamps[name].append(result.kinematics.stamp)
            self._fields[name].append(result.fields())
        for name, found in output.residuals.items():
            self._residuals[name].append((found.stamp, found.value))

    def of(self, name: str, tally: ReplayCounts) -> DamperReplayed:
        names = self._fields[name][0] if self._fields[name] else {}
        none = (np.zeros(0, np.int64), np.zeros(0))
        residuals = [np.concatenate(parts) for parts in zip(none, *self._residuals[name], strict=True)]
        return DamperReplayed(
            tally=tally,
            stamp=np.concatenate([np.zeros(0, np.int64), *self._stamps[name]]),
            fields={field: np.concatenate([result[field] for result in self._fields[name]]) for field in names},
            residual_stamp=residuals[0],
            residual=residuals[1],
        )


def _save_bag(results: ReplayResults, path: Path) -> None:
    (source,) = results.recording.sources
    options = ReplayOptions(tuple(results), *results.recording.window, results.max_gap)
    signal_map = results.recording.signal_map
    if isinstance(source, Path):
        replay_to(source, results.models, path, signal_map, options, lambda text: None)
        return
    with TemporaryDirectory(prefix="damper_estimator_") as folder:
        written = Path(folder) / "recording.mcap"
        write_part(storable(source), written)
        replay_to(written, results.models, path, signal_map, options, lambda text: None)


def _number(value: object) -> str:
    return f"{value:.17g}" if isinstance(value, float) else str(value)
