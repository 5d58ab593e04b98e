"""Feed-forward of the current over roads: a passive damper, a look-up table and an identified model compared."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from damper_estimator.control import LAWS, LEAD, ConstantCommand, InverseCommand, InverseModel, Law, TableCommand
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, load_model, save_model
from damper_estimator.vehicle import (
    CORNER_CASES,
    LIMITS,
    SURFACES,
    Corner,
    Trial,
    compare_commands,
    tracking_ratio,
)
from damper_estimator.workflows.cases import Progress, no_progress
from damper_estimator.workflows.results import Results
from damper_estimator.workflows.ride_training import TRAINING_SHARE, Trained, train

RIDE_LAWS = (*(name for name in LAWS if name != "passive"), "mixed")
"""Laws of the desired force; ``mixed`` is that of the corner."""

RIDE_DAMPERS = tuple(CORNER_CASES)
"""Simulated semi-active dampers."""

PASSIVE_CURRENT = 0.4
"""A, of the passive damper."""


@dataclass(frozen=True)
class DamperRide:
    """One simulated damper: its identified model and table, and the trials by surface and command."""

    trained: Trained
    surfaces: dict[str, dict[str, Trial]]

    @property
    def ratios(self) -> list[float]:
        """Force error with the model over that with the table, by surface."""
        return [tracking_ratio(trials) for trials in self.surfaces.values()]


@dataclass(frozen=True, repr=False, eq=False)
class RideResults(Results[DamperRide]):
    """The rides, by simulated damper."""

    @property
    def sentence(self) -> str:
        """The ratio of the force errors in one sentence."""
        ratios = [ratio for result in self.by_damper.values() for ratio in result.ratios]
        count = "one scenario" if len(ratios) == 1 else f"{len(ratios)} scenarios"
        return f"force error with the model over that with the table: {min(ratios):.2f} to {max(ratios):.2f} in {count}"

    def page(self) -> str:
        """One self-contained HTML page."""
        from damper_estimator.report import ride_page

        return ride_page({name: result.surfaces for name, result in self.by_damper.items()}, self.request["law"])

    def _record(self, result: DamperRide) -> dict[str, object]:
        scenarios = [
            {"surface": surface, "ratio": tracking_ratio(trials)}
            | {command: asdict(trial.measures) for command, trial in trials.items()}
            for surface, trials in result.surfaces.items()
        ]
        return {"rmse_fit_n": result.trained.rmse_n, "scenarios": scenarios}

    def _line(self, result: DamperRide) -> str:
        return f"model over table {min(result.ratios):.2f} to {max(result.ratios):.2f}"

    def _figure(self, result: DamperRide) -> Mapping[str, object]:
        from damper_estimator.report import ride_figure

        return ride_figure(result.surfaces)

    def _rows(self, result: DamperRide) -> list[dict[str, object]]:
        return [
            {"surface": surface, "command": command, **asdict(trial.measures)}
            for surface, trials in result.surfaces.items()
            for command, trial in trials.items()
        ]


def ride(
    model: str | Path | DamperModel = "semi_active_yield",
    dampers: Sequence[str] = (),
    *,
    law: str = "mixed",
    surfaces: Sequence[str] = (),
    seconds: float = 12.0,
    training: float = 40.0,
    seed: int = 1,
    folder: Path | None = None,
    progress: Progress | None = None,
) -> RideResults:
    """Drives simulated semi-active dampers over roads: passive, with a look-up table, and with an identified model.

    Table and model are trained on the same simulated recordings of each damper; then both receive the same desired
    force on the same roads.

    Args:
        model: structure to identify; its force must depend on the command.
        dampers: among `RIDE_DAMPERS`; all if empty.
        law: one of `RIDE_LAWS`.
        surfaces: ISO 8608 classes, ``bump`` or ``pothole``; all if empty.
        seconds: of a drive, 5 to 600.
        training: length of each training recording in s, 8 to 600.
        seed: of roads and noise, not negative.
        folder: receives the recordings and identified models; None keeps neither.
        progress: receives the current activity and the completed share of the work, 0 to 1.

    Raises:
        InputError: for values out of range, unknown names, and a model that does not depend on the command.
    """
    _check(dampers, law, surfaces, seconds, training, seed)
    start = model if isinstance(model, DamperModel) else load_model(model)
    InverseModel(start, LIMITS)  # rejects a model without current before any simulation
    roads = [surface for surface in SURFACES if not surfaces or surface.kind in surfaces]
    names, report = dampers or RIDE_DAMPERS, progress or no_progress
    found = {}
    with tempfile.TemporaryDirectory() as scratch:
        target = folder or Path(scratch)
        target.mkdir(parents=True, exist_ok=True)
        for i, name in enumerate(names):

            def part(text: str, share: float, i: int = i, name: str = name) -> None:
                report(f"{name}: {text}", (i + share) / len(names))

            corner = CORNER_CASES[name]
            trained = train(name, corner, start, target, training, seed, part)
            save_model(trained.model, target / f"{name}.yaml")
            trials = {}
            for k, road in enumerate(roads):
                part(road.name, TRAINING_SHARE + (1.0 - TRAINING_SHARE) * k / len(roads))
                trials[road.name] = compare_commands(corner, road, _commands(trained), seconds, seed, _law(corner, law))
            found[name] = DamperRide(trained, trials)
    named = str(model) if isinstance(model, (str, Path)) else start.name
    return RideResults({"model": named, "law": law, "seed": seed}, found)


def _commands(trained: Trained) -> dict[str, ConstantCommand | TableCommand | InverseCommand]:
    """New ones for each road; they have memory."""
    return {
        "passive": ConstantCommand(PASSIVE_CURRENT),
        "table": TableCommand(trained.table, LEAD),
        "model": InverseCommand(InverseModel(trained.model, LIMITS, lead=LEAD)),
    }


def _law(corner: Corner, name: str) -> Law:
    """The corner's law, or one half of it."""
    if name == "skyhook":
        return replace(corner.law, name=name, wheel=0.0)
    return replace(corner.law, name=name, body=0.0) if name == "groundhook" else corner.law


def _check(
    dampers: Sequence[str], law: str, surfaces: Sequence[str], seconds: float, training: float, seed: int
) -> None:
    faults = [f"{name!r} is not among {', '.join(known)}"
              for names, known in ((dampers, RIDE_DAMPERS), ([law], RIDE_LAWS), (surfaces, [s.kind for s in SURFACES]))
              for name in names if name not in known]  # fmt: skip
    if not 5.0 <= seconds <= 600.0:
        faults.append(f"seconds {seconds:g} is not between 5 and 600")
    if not 8.0 <= training <= 600.0:
        faults.append(f"training {training:g} is not between 8 and 600")
    if seed < 0:
        faults.append(f"seed {seed} is negative")
    if faults:
        raise InputError("; ".join(faults))
