"""The story of a hidden effect, on recordings that come with the package: before, finding, after.

A force-velocity curve is identified on a damper. Later the damper has changed, and on the road the model is wrong. The
diagnosis names the physical effect that is missing, and with it in the model the error is small again. Every command is
shown before it runs and can be repeated in FOLDER, which receives the recordings, models, pages and results; it also
holds the other sample recordings, on which the examples of each verb's help run.
"""

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from contextlib import chdir, nullcontext, redirect_stdout
from pathlib import Path

from damper_estimator.cli.common import STANDARD_OUTPUT, add_json, write_json
from damper_estimator.cli.main import DONE, PROGRAM, main
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
        "A force-velocity curve, identified on the damper as it was",
        ["fit hidden_base.mcap -m viscous_curve -o mine.yaml"],
    ),
    (
        "The same damper later, on the road: where does the model fail?",
        [f"compare hidden_unseen.mcap -m mine.yaml --json {BEFORE} --html {PAGES[0]}"],
    ),
    (
        "Which physical effect is missing? Sought on the bench recording, judged on the road",
        [f"diagnose {_JUDGED} --json {FINDING} --html {PAGES[1]}"],
    ),
    (
        "Have it added, as far as data that no fit has seen justify it",
        [
            f"improve {_JUDGED} -o better.yaml --html {PAGES[2]}",
            f"compare hidden_unseen.mcap -m better.yaml --json {AFTER}",
        ],
    ),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    parser.add_argument(
        "-o", "--output", metavar="FOLDER", type=Path, default=Path("damper_estimator_demo"),
        help="new folder, or that of an earlier demo (default: %(default)s)",
    )  # fmt: skip
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Copies the recordings, runs the commands, tells the result."""
    folder = arguments.output.absolute()
    copy_recordings(folder)
    apart = redirect_stdout(sys.stderr) if arguments.json == STANDARD_OUTPUT else nullcontext()
    with apart:
        status = _tell(folder)
        if status != DONE:
            return status
        found = result(folder)
        print(_in_words(found, folder))
    write_json(arguments.json, found)
    return DONE


def copy_recordings(folder: Path) -> None:
    """Copies the sample recordings into a folder.

    Raises:
        InputError: where the folder holds something else, or the installation has no recordings.
    """
    samples = sorted(share_path("bags").glob("*.mcap"))
    there = set(folder.iterdir()) if folder.is_dir() else {folder} if folder.exists() else set()
    if there and not {folder / sample.name for sample in samples} <= there:
        raise InputError(f"{folder}: is not the folder of an earlier demo; choose another one with -o")
    folder.mkdir(parents=True, exist_ok=True)
    for sample in samples:
        shutil.copyfile(sample, folder / sample.name)


def _tell(folder: Path) -> int:
    """Runs the story in the folder; the status of the first command that fails, else 0."""
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
    """Errors on the road before and after, the noise floor, and the best finding, from the files of the story."""

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


def _in_words(found: dict, folder: Path) -> str:
    tied = f", or {', '.join(found['tied_with'])}, which these data cannot tell from it" if found["tied_with"] else ""
    lines = [
        "\n== Result",
        f"before   rms error on the road {found['rmse_before_n']:.1f} N of {found['force_rms_n']:.0f} N rms force",
        f"finding  {found['found'] or found['verdict']}{tied}".replace("_", " "),
        f"after    {found['rmse_after_n']:.1f} N; the noise alone makes {found['noise_floor_n']:.1f} N",
        "",
        f"pages with the figures: {', '.join(str(folder / page) for page in PAGES)}",
        f"the commands above can be repeated in {folder}; with recordings of your own, start with:",
        f"  {PROGRAM} inspect YOUR.mcap            (a ROS 2 bag)",
        f"  {PROGRAM} import YOUR.csv --guess -o YOUR.mcap   (a bench or logger file)",
    ]
    return "\n".join(lines)
