"""The arguments shared by ``diagnose`` and ``improve``, and the cases that they name."""

import argparse
import os
from pathlib import Path

from damper_estimator.cli.verb_support import add_bags, add_models, add_reading, at_least, read_recordings, report_notes
from damper_estimator.errors import InputError
from damper_estimator.workflows import DiagnosisCases, diagnosis_cases


def add_diagnosis_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG... -m MODEL [--validate BAG]... [--keep-parameters | --refit] [--workers N]`` and the common arguments."""
    add_bags(parser)
    add_models(parser)
    parser.add_argument(
        "--validate", metavar="BAG", type=Path, action="append", default=[],
        help="judge on this recording; may be repeated (default: the last 40 %% of each BAG, or of several sections "
        "of it if the end moves faster or further)",
    )  # fmt: skip
    mode = parser.add_mutually_exclusive_group()
    mode.add_argument(
        "--keep-parameters", dest="mode", action="store_const", const="kept", default="both",
        help="judge every effect with the model's parameters unchanged (what has changed in the damper?)",
    )  # fmt: skip
    mode.add_argument(
        "--refit", dest="mode", action="store_const", const="refit", help="judge every effect refitted with the model"
    )
    parser.add_argument(
        "--workers", metavar="N", type=at_least(1), default=os.cpu_count() or 1,
        help="number of processes (default: one per core)",
    )  # fmt: skip
    add_reading(parser, html=True)


def read_cases(arguments: argparse.Namespace, use: str) -> DiagnosisCases:
    """The cases: every damper with its model and recordings.

    Raises:
        InputError: if a model, a recording or a measured force is missing.
    """
    fitted = {bag.resolve() for bag in arguments.bags}
    for bag in arguments.validate:
        if bag.resolve() in fitted:
            raise InputError(f"{bag}: is to be fitted and judged on; leave --validate out, or name another recording")
    recording = read_recordings(arguments)
    validate = read_recordings(arguments, arguments.validate) if arguments.validate else None
    cases = diagnosis_cases(recording, arguments.model, validate, use)
    report_notes(cases.notes)
    return cases
