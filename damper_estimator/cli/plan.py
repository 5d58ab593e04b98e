"""Design the test that tells tied explanations apart, or that sharpens a model's parameters.

BAG... and MODEL are those of the diagnosis; --diagnosis is the file that diagnose --json wrote (without it the
recordings are diagnosed first). The rig says what can be driven: a name of the library or a YAML file. Into DIR go
drive.csv (time, displacement), plan.yaml (steps, limits, predictions) and plan.html (what will differ, how sure the
decision will be). Record the test, then diagnose the old and the new recording together.
"""

import argparse
from pathlib import Path
from textwrap import fill

from damper_estimator.cli.common import (
    STANDARD_OUTPUT,
    add_bags,
    add_json,
    add_models,
    add_signals,
    add_window,
    progress,
    read_asked,
    write_json,
)
from damper_estimator.cli.work_line import WorkLine
from damper_estimator.errors import InputError
from damper_estimator.planning import Plan, load_rig
from damper_estimator.workflows import RIG, plan

EXAMPLES = (
    "plan hidden_fit.mcap hidden_unseen.mcap -m mine.yaml -o drive",
    "plan hidden_fit.mcap -m mine.yaml --parameters --rig crank --minutes 1 -o drive",
)
_WIDTH = 110


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    add_bags(parser)
    add_models(parser)
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, required=True, help="folder that gets the files")
    parser.add_argument(
        "--diagnosis", metavar="JSON", type=Path, help="what diagnose --json wrote (default: diagnose first)"
    )
    parser.add_argument(
        "--rig", metavar="RIG", default=RIG, help="a rig's name, or its file (YAML); default: %(default)s"
    )
    parser.add_argument(
        "--travel", metavar="M", nargs=2, type=float,
        help="displacements in m that the damper allows, lowest and highest (default: what BAG... drove)",
    )  # fmt: skip
    parser.add_argument(
        "--minutes", metavar="N", type=float,
        help="length of the test (default: the shortest that decides rightly with 95 %%, at most 10)",
    )  # fmt: skip
    parser.add_argument(
        "--parameters", action="store_true", help="sharpen the model's parameters; no diagnosis is needed"
    )
    add_signals(parser)
    add_window(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Plans a test for every damper that has a tie."""
    if arguments.parameters and arguments.diagnosis:
        raise InputError("--parameters needs no --diagnosis; leave one of them out")
    if arguments.output.is_file():
        raise InputError(f"{arguments.output}: is a file; name a folder for the plan")
    rig = load_rig(arguments.rig)
    recording = read_asked(arguments)
    with WorkLine("plan") as line:
        found = plan(
            recording, arguments.model, diagnosis=arguments.diagnosis, rig=rig, minutes=arguments.minutes,
            travel=None if arguments.travel is None else (arguments.travel[0], arguments.travel[1]),
            parameters=arguments.parameters, progress=line,
        )  # fmt: skip
    found.save(arguments.output)
    if arguments.json != STANDARD_OUTPUT:
        for damper, own in found.by_damper.items():
            _print(damper, own)
        said = " ".join(map(str, arguments.bags))
        print("next: record it, then", f"  damper-estimator diagnose {said} NEW -m {arguments.model}", sep="\n")
    progress(f"wrote {arguments.output}")
    write_json(arguments.json, found.to_dict())
    return 0


def _print(damper: str, own: Plan) -> None:
    print(fill(f"{damper}: {own.sentence}", _WIDTH, subsequent_indent="  "))
    for number, step in enumerate(own.steps, 1):
        print(f"  {number:2d}  {step.words}")
    if own.would:
        print("  what would tell them apart:")
        for text in own.would:
            print(fill(text, _WIDTH, initial_indent="    - ", subsequent_indent="      "))
    for one in own.parameters:
        print(f"  {one.address}: {one.value:.5g}, standard error {one.before:.2g} now, {one.after:.2g} with the test")
