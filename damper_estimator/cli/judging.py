"""The arguments that ``diagnose`` and ``improve`` share, and the recordings and models that they name."""

import argparse
import os
from pathlib import Path

from damper_estimator.cli.common import (
    add_bags,
    add_html,
    add_json,
    add_models,
    add_signals,
    add_window,
    progress,
    read_asked,
)
from damper_estimator.workflows import Judging, judging_of


def add_judging(parser: argparse.ArgumentParser) -> None:
    """``BAG... -m MODEL [--validate BAG]... [--keep-parameters | --refit] [--workers N]`` and what is common."""
    add_bags(parser)
    add_models(parser)
    parser.add_argument(
        "--validate", metavar="BAG", type=Path, action="append", default=[],
        help="judge on this recording; may be repeated (default: the last 40 %% of each BAG)",
    )  # fmt: skip
    way = parser.add_mutually_exclusive_group()
    way.add_argument(
        "--keep-parameters", dest="mode", action="store_const", const="kept", default="both",
        help="the model's parameters were right: what is new?",
    )  # fmt: skip
    way.add_argument(
        "--refit", dest="mode", action="store_const", const="refit", help="judge every effect refitted with the model"
    )
    parser.add_argument(
        "--workers", metavar="N", type=_positive, default=os.cpu_count() or 1,
        help="processes that work (default: one per core)",
    )  # fmt: skip
    add_signals(parser)
    add_window(parser)
    add_json(parser)
    add_html(parser)


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise ValueError(text)
    return number


def read_judging(arguments: argparse.Namespace, use: str) -> Judging:
    """What is to be judged: every damper with its model and recordings.

    Raises:
        InputError: where a model, a recording or a measured force is missing.
    """
    recording = read_asked(arguments)
    validate = read_asked(arguments, arguments.validate) if arguments.validate else None
    found = judging_of(recording, arguments.model, validate, use)
    for note in found.notes:
        progress(note)
    return found
