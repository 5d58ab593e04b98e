"""Design a test that separates tied explanations, or that makes a model's parameters more certain.

BAG... and MODEL are those of the diagnosis; --diagnosis is the file that diagnose --json wrote (without it the
recordings are diagnosed first). The rig, a library name or a YAML file, states the possible motion. DIR receives
drive.csv (time, displacement), plan.yaml (steps, limits, predictions) and plan.html (expected differences, certainty
of the decision). Record the test, then diagnose the old and the new recording together.
"""

import argparse
from pathlib import Path
from textwrap import fill

from damper_estimator.cli.progress_line import ProgressLine
from damper_estimator.cli.verb_support import (
    add_bags,
    add_models,
    add_reading,
    command,
    prints_text,
    progress,
    read_recordings,
    reading_words,
    write_json,
)
from damper_estimator.errors import InputError
from damper_estimator.planning import Plan, load_rig
from damper_estimator.workflows import RIG, plan

EXAMPLES = (
    "plan hidden_fit.mcap hidden_unseen.mcap -m mine.yaml -o drive",
    "plan hidden_fit.mcap -m mine.yaml --parameters --rig crank --minutes 1 -o drive",
)
_WIDTH = 110


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    add_bags(parser)
    add_models(parser)
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, required=True, help="folder for the files")
    parser.add_argument(
        "--diagnosis", metavar="JSON", type=Path, help="the file that diagnose --json wrote (default: diagnose first)"
    )
    parser.add_argument(
        "--rig", metavar="RIG", default=RIG, help="a rig's name, or its file (YAML); default: %(default)s"
    )
    parser.add_argument(
        "--travel", metavar="M", nargs=2, type=float,
        help="lowest and highest displacement in m that the damper allows (default: those in BAG...)",
    )  # fmt: skip
    parser.add_argument(
        "--minutes", metavar="N", type=float,
        help="length of the test (default: the shortest with a correct decision in 95 %% of cases, at most 10; "
        "2 with --parameters)",
    )  # fmt: skip
    parser.add_argument(
        "--parameters", action="store_true", help="make the model's parameters more certain; needs no diagnosis"
    )
    add_reading(parser)


def run(arguments: argparse.Namespace) -> int:
    """Plans a test for every damper that has a tie."""
    if arguments.parameters and arguments.diagnosis:
        raise InputError("--parameters and --diagnosis exclude each other; omit one of them")
    if arguments.output.is_file():
        raise InputError(f"{arguments.output}: is a file; name a folder for the plan")
    rig = load_rig(arguments.rig)
    recording = read_recordings(arguments)
    with ProgressLine("plan") as line:
        found = plan(
            recording, arguments.model, diagnosis=arguments.diagnosis, rig=rig, minutes=arguments.minutes,
            travel=None if arguments.travel is None else (arguments.travel[0], arguments.travel[1]),
            parameters=arguments.parameters, progress=line,
        )  # fmt: skip
    found.save(arguments.output)
    if prints_text(arguments):
        for damper, planned in found.by_damper.items():
            _print(damper, planned)
        if any(planned.may_separate for planned in found.by_damper.values()):
            given = (*arguments.bags, "NEW", "-m", arguments.model, *reading_words(arguments))
            words = ("fit", *given, "-o", "sharper.yaml") if arguments.parameters else ("diagnose", *given)
            print("next: record the test, then", f"  {command(*words)}", sep="\n")
    progress(f"wrote {arguments.output}")
    write_json(arguments.json, found.to_dict())
    return 0


def _print(damper: str, planned: Plan) -> None:
    print(fill(f"{damper}: {planned.sentence}", _WIDTH, subsequent_indent="  "))
    for number, (_, words) in enumerate(planned.listed, 1):
        print(f"  {number:2d}  {words}")
    if planned.would:
        print("  would separate them better:")
        for text in planned.would:
            print(fill(text, _WIDTH, initial_indent="    - ", subsequent_indent="      "))
    for p in planned.parameters:
        print(f"  {p.address}: {p.value:.5g}, standard error {p.before:.2g} now, {p.after:.2g} with the test")
