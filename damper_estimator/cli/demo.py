"""Demonstrate the search for a missing effect on recordings that come with the package.

A force-velocity curve is identified on a damper. Later the damper has changed, and the model is wrong on the road. The
diagnosis names the missing physical effect, and with it the model's error is small again. Every command is shown
before it runs and can be repeated in FOLDER, which receives recordings, models, pages and results, and also the sample
recordings for the examples in each verb's help.
"""

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from contextlib import chdir, nullcontext, redirect_stdout
from pathlib import Path

from damper_estimator.cli.main import DONE, PROGRAM, main
from damper_estimator.cli.verb_support import add_json, prints_text, write_json
from damper_estimator.errors import InputError
from damper_estimator.share import share_path

EXAMPLES = (
    "demo",
    "demo -o story --json story.json",
)
BEFORE, FINDING, AFTER = "before.json", "diagnosis.json", "after.json"
PAGES = ("comparison.html", "diagnosis.html", "improvement.html")
_JUDGED = "hidden_fit.mcap --validate hidden_unseen.mcap -m mine.yaml"
STORY = (
    (
        "Identify a force-velocity curve on the original damper",
        ["fit hidden_base.mcap -m viscous_curve -o mine.yaml"],
    ),
    (
        "Compare it with the same damper later on the road: where does the model fail?",
        [f"compare hidden_unseen.mcap -m mine.yaml --json {BEFORE} --html {PAGES[0]}"],
    ),
    (
        "Diagnose which physical effect is missing: identified on the bench recording, judged on the road",
        [f"diagnose {_JUDGED} --json {FINDING} --html {PAGES[1]}"],
    ),
    (
        "Add it, as far as unseen data justify",
        [
            f"improve {_JUDGED} -o better.yaml --html {PAGES[2]}",
            f"compare hidden_unseen.mcap -m better.yaml --json {AFTER}",
        ],
    ),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    parser.add_argument(
        "-o", "--output", metavar="FOLDER", type=Path, default=Path("damper_estimator_demo"),
        help="a new folder, or that of an earlier demo (default: %(default)s)",
    )  # fmt: skip
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Copies the recordings, runs the commands, prints the result."""
    folder = arguments.output.absolute()
    copy_recordings(folder)
    output = nullcontext() if prints_text(arguments) else redirect_stdout(sys.stderr)
    with output:
        status = _run_commands(folder)
        if status != DONE:
            return status
        found = result(folder)
        print(_summary(found, folder))
    write_json(arguments.json, found)
    return DONE


def copy_recordings(folder: Path) -> None:
    """Copies the sample recordings into a folder.

    Raises:
        InputError: if the folder has other content, or the installation lacks the recordings.
    """
    samples = sorted(share_path("bags").glob("*.mcap"))
    entries = set(folder.iterdir()) if folder.is_dir() else {folder} if folder.exists() else set()
    if entries and not {folder / sample.name for sample in samples} <= entries:
        raise InputError(f"{folder}: is not the folder of an earlier demo; choose another one with -o")
    folder.mkdir(parents=True, exist_ok=True)
    for sample in samples:
        shutil.copyfile(sample, folder / sample.name)


def _run_commands(folder: Path) -> int:
    """Runs the commands in the folder; returns the status of the first that fails, else 0."""
    with chdir(folder):
        for number, (title, commands) in enumerate(STORY, start=1):
            print(f"\n== {number}. {title}", flush=True)
            for command in commands:
                print(f"$ {PROGRAM} {command}", flush=True)
                status = main(command.split())
                if status != DONE:
                    return status
    return DONE


def result(folder: Path) -> dict[str, object]:
    """Errors on the road before and after, the noise floor, and the best finding, from the result files."""

    def damper(name: str) -> dict:
        (only,) = json.loads((folder / name).read_text(encoding="utf-8"))["dampers"].values()
        return only

    before, diagnosis, after = damper(BEFORE), damper(FINDING), damper(AFTER)
    findings: Sequence[dict] = diagnosis["findings"]
    return {
        "verdict": diagnosis["verdict"],
        "found": findings[0]["phenomenon"] if findings else None,
        "tied_with": findings[0]["tied_with"] if findings else [],
        "rmse_before_n": before["rmse_n"],
        "rmse_after_n": after["rmse_n"],
        "force_rms_n": before["force_rms_n"],
        "noise_floor_n": after["noise_floor_n"],
        "folder": str(folder),
    }


def _summary(found: dict, folder: Path) -> str:
    tied = (
        f", or {', '.join(found['tied_with'])}, which these data cannot distinguish from it"
        if found["tied_with"]
        else ""
    )
    lines = [
        "\n== Result",
        f"before   rms error on the road {found['rmse_before_n']:.1f} N of {found['force_rms_n']:.0f} N rms force",
        f"finding  {found['found'] or found['verdict']}{tied}".replace("_", " "),
        f"after    {found['rmse_after_n']:.1f} N; the noise alone causes {found['noise_floor_n']:.1f} N",
        "",
        f"pages with the figures: {', '.join(str(folder / page) for page in PAGES)}",
        f"the commands above can be repeated in {folder}; with your own recordings, start with:",
        f"  {PROGRAM} inspect YOUR.mcap            (a ROS 2 bag)",
        f"  {PROGRAM} import YOUR.csv --guess -o YOUR.mcap   (a bench or logger file)",
    ]
    return "\n".join(lines)
