"""What feed-forward of the current does to the ride: passive, by look-up table and by an identified model.

A quarter car with a simulated semi-active damper, its coil's lag and noisy sensors is driven over ISO 8608 roads and
single events. Table and model are made from the same recordings of that damper, which this verb makes first; then both
are given the same wish (a law of skyhook, groundhook or both mixed) over the same roads. Printed are the error of the
damper's force against the wish, cut to what the damper could have given, and what body, tyre and suspension felt.
-o keeps recordings and identified models.
"""

import argparse
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path

from damper_estimator.cli.common import STANDARD_OUTPUT, add_html, add_json, progress, write_json
from damper_estimator.cli.ride_training import Learnt, learn
from damper_estimator.control import (
    LAWS,
    ConstantCommand,
    InverseCommand,
    InverseModel,
    Law,
    TableCommand,
)
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
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
"""Trials by damper, surface and way."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    parser.add_argument(
        "-m", "--model", default="semi_active_yield", metavar="MODEL",
        help="structure to identify, a name or a file (semi_active_yield)",
    )  # fmt: skip
    parser.add_argument(
        "-d", "--damper", dest="dampers", choices=CORNER_CASES, action="append", default=[],
        help="only this one; may be repeated (all)",
    )  # fmt: skip
    parser.add_argument(
        "--law", choices=[*(name for name in LAWS if name != "passive"), "mixed"], default="mixed",
        help="skyhook, groundhook, or mixed as it suits the corner (mixed)",
    )  # fmt: skip
    parser.add_argument(
        "--surface", dest="surfaces", choices=sorted({own.kind for own in SURFACES}), action="append", default=[],
        help="only ISO 8608 class B, C or D, bumps or potholes; may be repeated (all)",
    )  # fmt: skip
    parser.add_argument("--seconds", type=float, default=12.0, help="length of a drive (12)")
    parser.add_argument("--training", type=float, default=40.0, help="length of each recording to learn from, s (40)")
    parser.add_argument("--seed", type=int, default=1, help="roads and noise are reproduced from it (1)")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="keep recordings and identified models here")
    add_json(parser)
    add_html(parser)


def run(arguments: argparse.Namespace) -> int:
    """Learns, drives, prints, writes."""
    _check(arguments)
    start = load_model(arguments.model)
    InverseModel(start, LIMITS)  # refuses a model without current before anything is simulated
    names = arguments.dampers or list(CORNER_CASES)
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.output or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        learnt = {
            name: learn(name, CORNER_CASES[name], start, folder, arguments.training, arguments.seed) for name in names
        }
        if arguments.output:
            for name, own in learnt.items():
                save_model(own.model, folder / f"{name}.yaml")
    found = {name: _driven(name, own, arguments) for name, own in learnt.items()}
    if arguments.json != STANDARD_OUTPUT:
        print(_text(found, learnt))
    write_json(arguments.json, _record(arguments, found, learnt))
    if arguments.html:
        from damper_estimator.report.ride_page import ride_page

        write_text(arguments.html, ride_page(found, arguments.law))
        progress(f"wrote {arguments.html}")
    return 0


def _check(arguments: argparse.Namespace) -> None:
    culprits = []
    if not 5.0 <= arguments.seconds <= 600.0:
        culprits.append(f"--seconds {arguments.seconds:g} is not between 5 and 600")
    if not 8.0 <= arguments.training <= 600.0:
        culprits.append(f"--training {arguments.training:g} is not between 8 and 600")
    if arguments.seed < 0:
        culprits.append(f"--seed {arguments.seed} is negative")
    if culprits:
        raise InputError("; ".join(culprits) + "; nothing was done")


def _law(corner: Corner, name: str) -> Law:
    """The corner's own law, or one half of it alone."""
    if name == "skyhook":
        return replace(corner.law, name=name, wheel=0.0)
    return replace(corner.law, name=name, body=0.0) if name == "groundhook" else corner.law


def _driven(name: str, learnt: Learnt, arguments: argparse.Namespace) -> dict[str, dict[str, Trial]]:
    corner, found = CORNER_CASES[name], {}
    for surface in SURFACES:
        if arguments.surfaces and surface.kind not in arguments.surfaces:
            continue
        progress(f"{name}: {surface.name}")
        commands = {
            "passive": ConstantCommand(PASSIVE_CURRENT),
            "table": TableCommand(learnt.table),
            "model": InverseCommand(InverseModel(learnt.model, LIMITS)),
        }
        law = _law(corner, arguments.law)
        found[surface.name] = compare_commands(corner, surface, commands, arguments.seconds, arguments.seed, law)
    return found


def _text(found: Found, learnt: Mapping[str, Learnt]) -> str:
    """The result for people; passive / table / model in every column but the ratio."""
    lines = []
    for name, surfaces in found.items():
        lines += [
            f"{name}: {learnt[name].model.name} identified to {learnt[name].rmse_n:.0f} N rms",
            "  passive / table / model   force error N    ratio   body m/s^2 (Wk)      tyre load %          stroke mm",
        ]
        for surface, trials in surfaces.items():
            rows = [own.measures for own in trials.values()]
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


def _record(arguments: argparse.Namespace, found: Found, learnt: Mapping[str, Learnt]) -> dict[str, object]:
    dampers = {
        name: {
            "rmse_fit_n": learnt[name].rmse_n,
            "scenarios": [
                {"surface": surface, "ratio": tracking_ratio(trials)}
                | {way: asdict(own.measures) for way, own in trials.items()}
                for surface, trials in surfaces.items()
            ],
        }
        for name, surfaces in found.items()
    }
    return {"model": arguments.model, "law": arguments.law, "seed": arguments.seed, "dampers": dampers}
