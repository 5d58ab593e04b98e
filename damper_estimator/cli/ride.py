"""Compare a passive damper with feed-forward of the current by a look-up table and by an identified model.

A quarter car with a simulated semi-active damper, its coil's lag and noisy sensors is driven over ISO 8608 roads and
single events. Table and model are trained on the same recordings of that damper, which this verb makes first; then
both receive the same desired force (skyhook, groundhook or mixed) on the same roads. Prints the error of the damper's
force relative to the desired force, limited to the range of the damper, and the motion of body, tyre and suspension.
-o stores recordings and identified models.
"""

import argparse
from pathlib import Path

from damper_estimator.cli.progress_line import ProgressLine
from damper_estimator.cli.verb_support import add_html, add_json, write_page, write_results
from damper_estimator.vehicle import CORNER_CASES, SURFACES, tracking_ratio
from damper_estimator.workflows import RIDE_LAWS, RideResults, ride

EXAMPLES = (
    "ride --surface bump --seconds 8",
    "ride --law skyhook -o ride --html ride.html",
)


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
        "--law", choices=RIDE_LAWS, default="mixed",
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
    with ProgressLine("ride") as line:
        found = ride(
            arguments.model, arguments.dampers, law=arguments.law, surfaces=arguments.surfaces,
            seconds=arguments.seconds, training=arguments.training, seed=arguments.seed, folder=arguments.output,
            progress=line,
        )  # fmt: skip
    write_results(arguments, _text(found), found.to_dict())
    if arguments.html:
        write_page(arguments.html, found.page())
    return 0


def _text(found: RideResults) -> str:
    """The results as text; passive / table / model in every column except the ratio."""
    lines = []
    for name, result in found.by_damper.items():
        lines += [
            f"{name}: {result.trained.model.name} identified to {result.trained.rmse_n:.0f} N rms",
            "  passive / table / model   force error N    ratio   body m/s^2 (Wk)      tyre load %          stroke mm",
        ]
        for surface, trials in result.surfaces.items():
            rows = [trial.measures for trial in trials.values()]
            columns = (
                " / ".join(f"{m.tracking_n:.0f}" for m in rows),
                f"{tracking_ratio(trials):.2f}",
                " / ".join(f"{m.weighted_acceleration:.2f}" for m in rows),
                " / ".join(f"{100 * m.tyre_load:.1f}" for m in rows),
                " / ".join(f"{1e3 * m.stroke:.1f}" for m in rows),
            )
            lines.append("  {:<22}{:>19}   {:>6}   {:>18}   {:>18}   {:>18}".format(surface, *columns))
    ratios = [ratio for result in found.by_damper.values() for ratio in result.ratios]
    lines.append(f"model over table: {min(ratios):.2f} to {max(ratios):.2f} in {len(ratios)} scenarios")
    return "\n".join(lines)
