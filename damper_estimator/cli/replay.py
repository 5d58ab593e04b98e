"""Run a model over a recording exactly as the node would; write the estimates next to their inputs.

Samples are taken in order of arrival, and slow channels hold the last message that arrived, so the forces are those
that the node gives, bit for bit. The output holds the topics that the signal map uses as they were,
``/damper_estimator/force`` (one message per displacement message that gave an estimate, at its log time and with its
stamp) and, where the force was measured, ``/damper_estimator/residual`` (effort = model - measured). An older output is
replaced.
"""

import argparse
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from damper_estimator.cli.common import add_bags, add_json, add_models, add_signals, add_window, progress, write_json
from damper_estimator.control import InverseModel, checked_limits, usable_limits
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, load_model
from damper_estimator.recordings import Bag, BagWriter, Batch, damper_forces, joint_states, open_bag
from damper_estimator.runtime import (
    SLOW,
    Arrivals,
    DamperEstimator,
    Deployed,
    Estimates,
    ResidualLine,
    VehicleLine,
    deployed,
    together,
)
from damper_estimator.signals import DEFAULT_MAX_GAP, Channel, Counts, SignalMap, load_signal_map
from damper_estimator.signals.admission import DUPLICATE
from damper_estimator.signals.channels import find_topic, signals_for

FORCE, FORCE_TYPE = "/damper_estimator/force", "damper_msgs/msg/DamperForces"
RESIDUAL, RESIDUAL_TYPE = "/damper_estimator/residual", "sensor_msgs/msg/JointState"
_NO_STAMPS = np.zeros(0, np.int64)


@dataclass
class Tally:
    """What became of one damper's samples."""

    counts: Counts = field(default_factory=Counts)
    estimates: int = 0
    not_finite: int = 0
    residuals: int = 0
    squared_residual: float = 0.0

    def record(self) -> dict[str, object]:
        """For JSON."""
        names = ("samples", "gaps", "steps_back", "inversions", "duplicates", "non_finite")
        rms = float(np.sqrt(self.squared_residual / self.residuals)) if self.residuals else None
        own = {"estimates": self.estimates, "force_not_finite": self.not_finite}
        return (
            {name: getattr(self.counts, name) for name in names}
            | own
            | {"residuals": self.residuals, "residual_rms_n": rms}
        )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG -m MODEL -o BAG`` and what is common."""
    add_bags(parser, several=False)
    add_models(parser)
    parser.add_argument("-o", "--output", metavar="BAG", type=Path, required=True, help="the .mcap file to write")
    add_signals(parser)
    add_window(parser)
    parser.add_argument(
        "--max-gap",
        metavar="S",
        type=float,
        default=DEFAULT_MAX_GAP,
        help="a longer gap between stamps resets the state (%(default)g s)",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Replays one recording; see the module's docstring."""
    _refuse_input_as_output(arguments.bag, arguments.output)
    signal_map = load_signal_map(arguments.signals)
    with open_bag(arguments.bag) as bag:
        chosen = _chosen(bag, signal_map, arguments.dampers)
        models = {name: load_model(arguments.model, name) for name in chosen.dampers}
        _tell_cutoffs(models, chosen.cutoff)
        with BagWriter(arguments.output) as writer:
            tallies = Replay(bag, chosen, models, arguments.max_gap, arguments.start, arguments.stop).write(writer)
    write_json(
        arguments.json, {"output": str(arguments.output), "dampers": {name: t.record() for name, t in tallies.items()}}
    )
    if arguments.json != "-":
        _print(tallies, arguments.output)
    return 0


def _refuse_input_as_output(bag: Path, output: Path) -> None:
    here, there = bag.resolve(), output.resolve()
    if there == here or here in there.parents or (bag.exists() and output.exists() and bag.samefile(output)):
        raise InputError(f"{output}: is the recording itself; give another name with -o")


def _chosen(bag: Bag, signal_map: SignalMap, names: list[str]) -> SignalMap:
    whole = signals_for(bag, signal_map)
    for name in names:
        signals_for(bag, whole, name)
    dampers = {name: own for name, own in whole.dampers.items() if not names or name in names}
    return replace(whole, dampers=dampers)


def _tell_cutoffs(models: Mapping[str, DamperModel], cutoff: float) -> None:
    for name, model in models.items():
        fitted = model.fit.get("cutoff")
        if fitted is not None and float(fitted or 0.0) != cutoff:
            progress(
                f"{name}: model {model.name} was fitted with the filter at {fitted or 'none'} Hz, here it is "
                f"at {cutoff or 'none'} Hz"
            )


class Replay:
    """One pass over a recording in batches; memory does not grow with its length; final."""

    def __init__(
        self,
        bag: Bag,
        chosen: SignalMap,
        models: Mapping[str, DamperModel],
        max_gap: float,
        start: float | None,
        stop: float | None,
    ):
        self._bag = bag
        self._dampers = chosen.dampers
        self._window = (-np.inf if start is None else start, np.inf if stop is None else stop)
        dampers = {
            name: deployed(model, chosen.cutoff, max_gap, fusion=chosen.fusion, signals=chosen.dampers[name])
            for name, model in models.items()
        }
        self._line = VehicleLine({name: DamperEstimator(own) for name, own in dampers.items()}, _reaches(dampers))
        self._tallies = {name: Tally() for name in models}
        self._fields: dict[str, list[tuple[str, str, Channel]]] = {}
        for name, signals in chosen.dampers.items():
            for role in ("displacement", "force", *SLOW, *(("acceleration",) if chosen.fusion else ())):
                self._find(name, role, getattr(signals, role))
        measured = {name for entries in self._fields.values() for name, role, _ in entries if role == "force"}
        self._residuals = {
            n: ResidualLine(chosen.dampers[n], chosen.gauge_cutoff, max_gap) for n in models if n in measured
        }
        self._origin: int | None = None

    def _find(self, damper: str, role: str, channel: Channel) -> None:
        topic = find_topic(self._bag, channel.topic)
        if topic is not None:
            self._fields.setdefault(topic, []).append((damper, role, channel))
        elif channel.given or role == "displacement":
            there = ", ".join(t.name for t in self._bag.topics) or "none"
            raise InputError(
                f"{self._bag.path}: has no topic {channel.topic} ({damper}, {role}); it has {there}; mend the "
                "signal map"
            )

    def write(self, writer: BagWriter, size: int = 65536) -> dict[str, Tally]:
        """Writes inputs, estimates and residuals; what became of each damper's samples."""
        seen, total = 0, sum(t.messages for t in self._bag.topics if t.name in self._fields)
        for batch in self._bag.batches(list(self._fields), size):
            writer.write_batch(batch)
            self._batch(writer, batch)
            seen += len(batch)
            if total > 1_000_000:
                progress(f"replayed {seen} of {total} messages")
        for name, tally in self._tallies.items():
            if not tally.counts.samples:
                channel = self._dampers[name].displacement
                raise InputError(
                    f"{self._bag.path}: topic {channel.topic} never has the field {channel.field} (damper {name}); "
                    "mend the signal map or choose another damper with -d"
                )
        return self._tallies

    def _batch(self, writer: BagWriter, batch: Batch) -> None:
        displacement: dict[str, Arrivals] = {}
        log: dict[str, np.ndarray] = {}
        slow: dict[str, dict[str, Arrivals]] = {name: {} for name in self._dampers}
        gauge: dict[str, Arrivals] = {}
        if self._origin is None and len(batch):
            self._origin = int(batch.log.min())
        for topic, entries in self._fields.items():
            columns = batch.columns(topic, tuple(channel.field for _, _, channel in entries))
            for i, (name, role, channel) in enumerate(entries):
                there = columns.present[:, i] & (self._inside(columns.log) if role == "displacement" else True)
                arrivals = Arrivals(columns.rank[there], columns.stamp[there], channel.value(columns.values[there, i]))
                if role == "displacement":
                    displacement[name], log[name] = arrivals, columns.log[there]
                else:
                    (gauge if role == "force" else slow[name]).update({name if role == "force" else role: arrivals})
        messages, estimates = self._line.block(displacement, slow)
        ranks, logs = _sorted_logs(displacement, log)
        for m in messages:
            at = logs[np.searchsorted(ranks, m.rank)]
            writer.write_messages(FORCE, FORCE_TYPE, at, damper_forces(m.names, m.stamp, m.fields))
        self._count(estimates)
        self._write_residuals(writer, estimates, log, gauge)

    def _inside(self, log: np.ndarray) -> np.ndarray:
        elapsed = (log - (self._origin or 0)) * 1e-9
        return (elapsed >= self._window[0]) & (elapsed <= self._window[1])

    def _count(self, estimates: Mapping[str, Estimates]) -> None:
        for name, own in estimates.items():
            tally = self._tallies[name]
            tally.counts += Counts.of(own.verdict)
            tally.estimates += own.force.size
            tally.not_finite += int(np.count_nonzero(np.isnan(own.force)))

    def _write_residuals(
        self,
        writer: BagWriter,
        estimates: Mapping[str, Estimates],
        log: Mapping[str, np.ndarray],
        gauge: Mapping[str, Arrivals],
    ) -> None:
        told = {}
        for name, line in self._residuals.items():
            own, measured = estimates.get(name), gauge.get(name)
            told[name] = line.block(
                own,
                log[name][own.verdict < DUPLICATE] if own is not None else _NO_STAMPS,
                measured.stamp if measured is not None else _NO_STAMPS,
                measured.value if measured is not None else np.zeros(0),
            )
            finite = told[name].value[np.isfinite(told[name].value)]
            self._tallies[name].residuals += finite.size
            self._tallies[name].squared_residual += float(np.sum(finite**2))
        for stamp, rows in together({name: residuals.stamp for name, residuals in told.items()}):
            first = next(iter(rows))
            effort = np.stack([told[name].value[own] for name, own in rows.items()], axis=1)
            writer.write_messages(
                RESIDUAL, RESIDUAL_TYPE, told[first].log[rows[first]], joint_states(list(rows), stamp, effort=effort)
            )


def _reaches(dampers: Mapping[str, Deployed]) -> dict[str, Callable]:
    """What commands can reach, for those dampers whose model has an inverse; as the node with its default settings."""
    found = {}
    for name, own in dampers.items():
        with suppress(InputError):
            checked_limits(own.model, own.signals.command.value_limits)
            found[name] = InverseModel(own.model, usable_limits(name, own)[0]).reach
    return found


def _sorted_logs(displacement: Mapping[str, Arrivals], log: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Log times of all displacement messages by rank."""
    rank = np.concatenate([_NO_STAMPS, *(own.rank for own in displacement.values())])
    logs = np.concatenate([_NO_STAMPS, *log.values()])
    ranks, first = np.unique(rank, return_index=True)
    return ranks, logs[first]


def _print(tallies: Mapping[str, Tally], output: Path) -> None:
    for name, tally in tallies.items():
        counts = tally.counts
        lost = {"equal stamps": counts.duplicates, "older stamps": counts.inversions, "not finite": counts.non_finite}
        dropped = ", ".join(f"{count} {what}" for what, count in lost.items() if count)
        resets = ", ".join(
            f"{n} {what}" for what, n in {"gaps": counts.gaps, "steps back": counts.steps_back}.items() if n
        )
        line = f"{name}: {tally.estimates} estimates of {counts.samples} samples"
        line += f"; dropped {dropped}" if dropped else ""
        line += f"; reset by {resets}" if resets else ""
        line += f"; {tally.not_finite} forces are not finite" if tally.not_finite else ""
        if tally.residuals:
            line += f"; residual {np.sqrt(tally.squared_residual / tally.residuals):.4g} N rms"
        print(line)
    print(f"wrote {output}")
