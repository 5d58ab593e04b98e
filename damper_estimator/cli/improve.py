"""Add missing effects to a model and refit, until unseen data justify no further change.

The results list every step: its error, the effects tried and rejected, and with --steps-dir the model file. An effect
that a later one makes unnecessary is removed. With several dampers -o is a folder that receives one DAMPER.yaml each.
Faults of the measurement chain are not added to the model: --signals-out writes a signal map with corrections.
"""

import argparse
from pathlib import Path

from damper_estimator.cli.diagnosis_arguments import add_diagnosis_arguments, read_cases
from damper_estimator.cli.diagnosis_text import print_improvement
from damper_estimator.cli.progress_line import ProgressLine
from damper_estimator.cli.verb_support import check_output_folders, prints_text, write_json, write_page
from damper_estimator.diagnosis import Improvement
from damper_estimator.model import save_model
from damper_estimator.signals import save_signal_map
from damper_estimator.workflows import Case, ImprovementResults, improve_case, improvement_record, output_paths

EXAMPLES = (
    "improve hidden_fit.mcap --validate hidden_unseen.mcap -m mine.yaml -o better.yaml --html improvement.html",
    "improve hidden_fit.mcap -m mine.yaml -o better.yaml --steps-dir steps --signals-out map.yaml",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    add_diagnosis_arguments(parser)
    parser.add_argument(
        "-o", "--output", metavar="MODEL.yaml", type=Path, required=True,
        help="file for the improved model; a folder for several dampers",
    )  # fmt: skip
    parser.add_argument(
        "--signals-out",
        metavar="MAP.yaml",
        type=Path,
        help="write the signal map with corrections of the measurement chain",
    )
    parser.add_argument("--steps-dir", metavar="DIR", type=Path, help="folder for the model after each step")


def run(arguments: argparse.Namespace) -> int:
    """Improves every damper's model, then writes all files."""
    check_output_folders(arguments.html, arguments.signals_out, arguments.json)
    cases = read_cases(arguments, "improve")
    targets = output_paths(arguments.output, [case.damper for case in cases.cases])
    found = {case.damper: _improved(case, arguments) for case in cases.cases}
    results = ImprovementResults(cases.request, found, cases.signal_map)
    page = results.page() if arguments.html else ""
    files = {
        damper: _save(improvement, targets[damper], _steps_folder(arguments, damper, len(found)))
        for damper, improvement in found.items()
    }
    if arguments.signals_out:
        save_signal_map(results.corrected_map(), arguments.signals_out)
    if arguments.html:
        write_page(arguments.html, page)
    if prints_text(arguments):
        for damper, improvement in found.items():
            print_improvement(damper, improvement, [targets[damper]], arguments.signals_out)
        if arguments.signals_out:
            print(f"wrote {arguments.signals_out}")
    records = {
        damper: improvement_record(improvement, targets[damper], tuple(files[damper]))
        for damper, improvement in found.items()
    }
    write_json(arguments.json, cases.request | {"signals_out": arguments.signals_out, "dampers": records})
    return 0


def _improved(case: Case, arguments: argparse.Namespace) -> Improvement:
    with ProgressLine(case.damper) as line:
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
