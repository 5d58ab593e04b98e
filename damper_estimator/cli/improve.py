"""Diagnose, add what is missing, refit, again, until nothing more is justified on data that the fit never saw.

Every step is kept: the error after it, what was tried and rejected, and with --steps-dir the model file. An effect that
a later one made needless is taken out again. With several dampers -o is a folder that receives one DAMPER.yaml each.
Mistakes of the measurement chain never go into the model: --signals-out writes a signal map with their corrections.
"""

import argparse
from pathlib import Path

from damper_estimator.cli.common import STANDARD_OUTPUT, check_places, progress, write_json
from damper_estimator.cli.diagnosis_text import print_improvement
from damper_estimator.cli.judging import add_judging, read_judging
from damper_estimator.cli.work_line import WorkLine
from damper_estimator.diagnosis import Improvement
from damper_estimator.files import write_text
from damper_estimator.model import save_model
from damper_estimator.signals import save_signal_map
from damper_estimator.workflows import Case, ImprovementResults, improve_case, improvement_record, output_paths

EXAMPLES = (
    "improve hidden_fit.mcap --validate hidden_unseen.mcap -m mine.yaml -o better.yaml --html improvement.html",
    "improve hidden_fit.mcap -m mine.yaml -o better.yaml --steps-dir steps --signals-out map.yaml",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    add_judging(parser)
    parser.add_argument(
        "-o", "--output", metavar="MODEL.yaml", type=Path, required=True,
        help="where the improved model goes; a folder for several dampers",
    )  # fmt: skip
    parser.add_argument(
        "--signals-out",
        metavar="MAP.yaml",
        type=Path,
        help="write the signal map with corrections of the measurement chain",
    )
    parser.add_argument("--steps-dir", metavar="DIR", type=Path, help="keep the model file after each step there")


def run(arguments: argparse.Namespace) -> int:
    """Improves every damper's model, then writes all files."""
    check_places(arguments.html, arguments.signals_out, arguments.json)
    given = read_judging(arguments, "improve")
    targets = output_paths(arguments.output, [case.damper for case in given.cases])
    found = {case.damper: _improved(case, arguments) for case in given.cases}
    results = ImprovementResults(given.asked, found, given.signal_map)
    page = results.page() if arguments.html else ""
    files = {
        damper: _save(own, targets[damper], _steps_folder(arguments, damper, len(found)))
        for damper, own in found.items()
    }
    if arguments.signals_out:
        save_signal_map(results.corrected_map(), arguments.signals_out)
    if arguments.html:
        write_text(arguments.html, page)
        progress(f"wrote {arguments.html}")
    if arguments.json != STANDARD_OUTPUT:
        for damper, own in found.items():
            print_improvement(damper, own, [targets[damper]], arguments.signals_out)
        if arguments.signals_out:
            print(f"wrote {arguments.signals_out}")
    records = {damper: improvement_record(own, targets[damper], tuple(files[damper])) for damper, own in found.items()}
    write_json(arguments.json, given.asked | {"signals_out": arguments.signals_out, "dampers": records})
    return 0


def _improved(case: Case, arguments: argparse.Namespace) -> Improvement:
    with WorkLine(case.damper) as line:
        return improve_case(case, arguments.mode, arguments.workers, line)


def _steps_folder(arguments: argparse.Namespace, damper: str, count: int) -> Path | None:
    if arguments.steps_dir is None:
        return None
    return arguments.steps_dir / damper if count > 1 else arguments.steps_dir


def _save(found: Improvement, target: Path, folder: Path | None) -> list[Path]:
    """Writes the improved model and those of the steps; returns the files of the steps."""
    target.parent.mkdir(parents=True, exist_ok=True)
    save_model(found.model, target)
    if folder is None:
        return []
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for number, step in enumerate(found.steps):
        files.append(folder / f"{number:02d}_{'_'.join(part for part in (step.action, step.effect) if part)}.yaml")
        save_model(step.model, files[-1])
    return files
