"""Which physical effects a model lacks, how sure that is, and what else it could be.

Every effect that stands for a phenomenon is tried on the model, its parameters identified on BAG..., and judged on
recordings that were not used for that: those given with --validate, or the last 40 % of each BAG. It is judged both
with the model's parameters as they are and refitted with it; --keep-parameters and --refit restrict it to one.
Mistakes of the measurement chain are told first; they are corrected in the signal map, never in the model.
"""

import argparse

from damper_estimator.cli.common import STANDARD_OUTPUT, check_places, progress, write_json
from damper_estimator.cli.diagnosis_text import next_steps, print_diagnosis
from damper_estimator.cli.judging import add_judging, read_judging
from damper_estimator.cli.work_line import WorkLine
from damper_estimator.workflows import DiagnosisResults, diagnose_case

EXAMPLES = (
    "diagnose hidden_fit.mcap --validate hidden_unseen.mcap -m mine.yaml --html diagnosis.html",
    "diagnose hidden_fit.mcap -m mine.yaml --keep-parameters --json diagnosis.json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    add_judging(parser)


def run(arguments: argparse.Namespace) -> int:
    """Diagnoses every damper; see the module's docstring."""
    check_places(arguments.html, arguments.json)
    found = {}
    given = read_judging(arguments, "diagnose")
    for case in given.cases:
        with WorkLine(case.damper) as line:
            found[case.damper] = diagnose_case(case, arguments.mode, arguments.workers, line)
        if arguments.json != STANDARD_OUTPUT:
            print_diagnosis(case.damper, found[case.damper])
    if arguments.json != STANDARD_OUTPUT:
        print(*next_steps(found, arguments.bags, arguments.validate, arguments.model), sep="\n", end="")
    results = DiagnosisResults(given.asked, found)
    if arguments.html:
        results.save(arguments.html)
        progress(f"wrote {arguments.html}")
    write_json(arguments.json, results.to_dict())
    return 0
