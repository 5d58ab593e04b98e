"""Which physical effects a model lacks, how sure that is, and what else it could be.

Every effect that stands for a phenomenon is tried on the model, its parameters identified on BAG..., and judged on
recordings that were not used for that: those given with --validate, or the last 40 % of each BAG. It is judged both
with the model's parameters as they are and refitted with it; --keep-parameters and --refit restrict it to one.
Mistakes of the measurement chain are told first; they are mended in the signal map, never in the model.
"""

import argparse

from damper_estimator.cli.common import STANDARD_OUTPUT, progress, write_json
from damper_estimator.cli.diagnosis_text import next_steps, print_diagnosis
from damper_estimator.cli.judging import add_judging, check_places, in_words, read_cases
from damper_estimator.cli.work_line import WorkLine
from damper_estimator.diagnosis import diagnose
from damper_estimator.files import write_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    add_judging(parser)


def run(arguments: argparse.Namespace) -> int:
    """Diagnoses every damper; see the module's docstring."""
    check_places(arguments.html, None if arguments.json == STANDARD_OUTPUT else arguments.json)
    found = {}
    for case in read_cases(arguments):
        with WorkLine(case.damper) as told:
            found[case.damper] = diagnose(
                case.model, case.fit, case.unseen, mode=arguments.mode, workers=arguments.workers, progress=told
            )
        if arguments.json != STANDARD_OUTPUT:
            print_diagnosis(case.damper, found[case.damper])
    if arguments.json != STANDARD_OUTPUT:
        print(*next_steps(found, arguments.bags, arguments.validate, arguments.model), sep="\n", end="")
    if arguments.html:
        from damper_estimator.report import diagnosis_page, diagnosis_section

        sections = [diagnosis_section(damper, own) for damper, own in found.items()]
        write_text(
            arguments.html, diagnosis_page(sections, f"what {arguments.model} lacks on {in_words(arguments.bags)}")
        )
        progress(f"wrote {arguments.html}")
    records = {damper: {"model": own.model.name, **own.record()} for damper, own in found.items()}
    asked = {"bags": arguments.bags, "validate": arguments.validate, "model": arguments.model}
    write_json(arguments.json, asked | {"dampers": records})
    return 0
