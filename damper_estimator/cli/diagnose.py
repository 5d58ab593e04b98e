"""Find the physical effects that a model lacks, with confidence and alternatives.

Each effect that represents a phenomenon is added to the model, identified on BAG... and judged on unseen recordings:
those given with --validate, or 40 % of each BAG. The effect is judged twice, with the model's parameters
unchanged and refitted; --keep-parameters and --refit select one of these. Faults of the measurement chain are reported
first; they are corrected in the signal map, never in the model.
"""

import argparse

from damper_estimator.cli.diagnosis_arguments import add_diagnosis_arguments, read_cases
from damper_estimator.cli.diagnosis_text import next_steps, print_diagnosis
from damper_estimator.cli.progress_line import ProgressLine
from damper_estimator.cli.verb_support import check_output_folders, prints_text, progress, reading_words, write_json
from damper_estimator.workflows import DiagnosisResults, diagnose_case

EXAMPLES = (
    "diagnose hidden_fit.mcap --validate hidden_unseen.mcap -m mine.yaml --html diagnosis.html",
    "diagnose hidden_fit.mcap -m mine.yaml --keep-parameters --json diagnosis.json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    add_diagnosis_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Diagnoses every damper."""
    check_output_folders(arguments.html, arguments.json)
    found = {}
    cases = read_cases(arguments, "diagnose")
    for case in cases.cases:
        with ProgressLine(case.damper) as line:
            found[case.damper] = diagnose_case(case, arguments.mode, arguments.workers, line)
        if prints_text(arguments):
            print_diagnosis(case.damper, found[case.damper])
    if prints_text(arguments):
        steps = next_steps(found, arguments.bags, arguments.validate, arguments.model, reading_words(arguments))
        print(*steps, sep="\n", end="")
    results = DiagnosisResults(cases.request, found)
    if arguments.html:
        results.save(arguments.html)
        progress(f"wrote {arguments.html}")
    write_json(arguments.json, results.to_dict())
    return 0
