"""Compare a passive damper with feed-forward of the current by a look-up table and by an identified model.

A quarter car with a simulated semi-active damper, its coil's lag and noisy sensors is driven over ISO 8608 roads and
single events. Table and model are trained on the same recordings of that damper, which this verb makes first; then
both receive the same desired force (skyhook, groundhook or mixed) on the same roads. Prints the error of the damper's
force relative to the desired force, limited to the range of the damper, and the motion of body, tyre and suspension.
-o stores recordings and identified models.
"""

import argparse
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path

from damper_estimator.cli.ride_training import Trained, train
from damper_estimator.cli.verb_support import add_html, add_json, progress, write_page, write_results
from damper_estimator.control import (
    LAWS,
    ConstantCommand,
    InverseCommand,
    InverseModel,
    Law,
    TableCommand,
)
from damper_estimator.errors import InputError
from damper_estimator.model import load_model, save_model
from damper_estimator.vehicle import CORNER_CASES, LIMITS, SURFACES, Corner
from damper_estimator.vehicle.command_comparison import Trial, compare_commands, tracking_ratio

EXAMPLES = (
    "ride --surface bump --seconds 8",
    "ride --law skyhook -o ride --html ride.html",
)
PASSIVE_CURRENT = 0.4
"""A, of the passive damper."""

Found = dict[str, dict[str, dict[str, Trial]]]
"""Trials by damper, surface and controller."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    parser.add_argument(
        "-m", "--model", default="semi_active_yield", metavar="MODEL",
        help="structure to identify, a name or a file (semi_active_yield)",
    )  # fmt: skip
    parser.add_argument(
        "-d", "--damper", dest="dampers", choices=CORNER_CASES, action="append", default=[],
        help="use only this one; may be repeated (all)",
    )  # fmt: skip
    parser.add_argument(
        "--law", choices=[*(name for name in LAWS if name != "passive"), "mixed"], default="mixed",
        help="skyhook, groundhook, or a mixture that suits the corner (mixed)",
    )  # fmt: skip
    parser.add_argument(
        "--surface", dest="surfaces", choices=sorted({s.kind for s in SURFACES}), action="append", default=[],
        help="use only ISO 8608 class B, C or D, bumps or potholes; may be repeated (all)",
    )  # fmt: skip
    parser.add_argument("--seconds", type=float, default=12.0, help="length of a drive (12)")
    parser.add_argument("--training", type=float, default=40.0, help="length of each training recording, s (40)")
    parser.add_argument("--seed", type=int, default=1, help="roads and noise are reproduced from it (1)")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="folder for recordings and identified models")
    add_json(parser)
    add_html(parser)


def run(arguments: argparse.Namespace) -> int:
    """Trains, drives, prints, writes."""
    _check(arguments)
    start = load_model(arguments.model)
    InverseModel(start, LIMITS)  # rejects a model without current before any simulation
    names = arguments.dampers or list(CORNER_CASES)
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.output or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        trained_dampers = {
            name: train(name, CORNER_CASES[name], start, folder, arguments.training, arguments.seed) for name in names
        }
        if arguments.output:
            for name, trained in trained_dampers.items():
                save_model(trained.model, folder / f"{name}.yaml")
    found = {name: _driven(name, trained, arguments) for name, trained in trained_dampers.items()}
    write_results(arguments, _text(found, trained_dampers), _record(arguments, found, trained_dampers))
    if arguments.html:
        from damper_estimator.report.ride_page import ride_page

        write_page(arguments.html, ride_page(found, arguments.law))
    return 0


def _check(arguments: argparse.Namespace) -> None:
    faults = []
    if not 5.0 <= arguments.seconds <= 600.0:
        faults.append(f"--seconds {arguments.seconds:g} is not between 5 and 600")
    if not 8.0 <= arguments.training <= 600.0:
        faults.append(f"--training {arguments.training:g} is not between 8 and 600")
    if arguments.seed < 0:
        faults.append(f"--seed {arguments.seed} is negative")
    if faults:
        raise InputError("; ".join(faults) + "")


def _law(corner: Corner, name: str) -> Law:
    """The corner's law, or one half of it."""
    if name == "skyhook":
        return replace(corner.law, name=name, wheel=0.0)
    return replace(corner.law, name=name, body=0.0) if name == "groundhook" else corner.law


def _driven(name: str, trained: Trained, arguments: argparse.Namespace) -> dict[str, dict[str, Trial]]:
    corner, found = CORNER_CASES[name], {}
    for surface in SURFACES:
        if arguments.surfaces and surface.kind not in arguments.surfaces:
            continue
        progress(f"{name}: {surface.name}")
        commands = {
            "passive": ConstantCommand(PASSIVE_CURRENT),
            "table": TableCommand(trained.table),
            "model": InverseCommand(InverseModel(trained.model, LIMITS)),
        }
        law = _law(corner, arguments.law)
        found[surface.name] = compare_commands(corner, surface, commands, arguments.seconds, arguments.seed, law)
    return found


def _text(found: Found, trained_dampers: Mapping[str, Trained]) -> str:
    """The results as text; passive / table / model in every column except the ratio."""
    lines = []
    for name, surfaces in found.items():
        lines += [
            f"{name}: {trained_dampers[name].model.name} identified to {trained_dampers[name].rmse_n:.0f} N rms",
            "  passive / table / model   force error N    ratio   body m/s^2 (Wk)      tyre load %          stroke mm",
        ]
        for surface, trials in surfaces.items():
            rows = [trial.measures for trial in trials.values()]
            columns = (
                " / ".join(f"{m.tracking_n:.0f}" for m in rows),
                f"{tracking_ratio(trials):.2f}",
                " / ".join(f"{m.weighted_acceleration:.2f}" for m in rows),
                " / ".join(f"{100 * m.tyre_load:.1f}" for m in rows),
                " / ".join(f"{1e3 * m.stroke:.1f}" for m in rows),
            )
            lines.append("  {:<22}{:>19}   {:>6}   {:>18}   {:>18}   {:>18}".format(surface, *columns))
    ratios = [tracking_ratio(trials) for surfaces in found.values() for trials in surfaces.values()]
    lines.append(f"model over table: {min(ratios):.2f} to {max(ratios):.2f} in {len(ratios)} scenarios")
    return "\n".join(lines)


def _record(arguments: argparse.Namespace, found: Found, trained_dampers: Mapping[str, Trained]) -> dict[str, object]:
    dampers = {
        name: {
            "rmse_fit_n": trained_dampers[name].rmse_n,
            "scenarios": [
                {"surface": surface, "ratio": tracking_ratio(trials)}
                | {controller: asdict(trial.measures) for controller, trial in trials.items()}
                for surface, trials in surfaces.items()
            ],
        }
        for name, surfaces in found.items()
    }
    return {"model": arguments.model, "law": arguments.law, "seed": arguments.seed, "dampers": dampers}
