"""What ``diagnose`` and ``improve`` share: the recordings to find on and to judge on, and how candidates are judged."""

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from damper_estimator.cli.common import add_bags, add_html, add_json, add_models, add_signals, add_window, progress
from damper_estimator.cli.fit import read
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, load_model
from damper_estimator.signals import Measurement, load_signal_map


@dataclass(frozen=True)
class Case:
    """One damper: the user's model and the recordings; without ``unseen`` the last 40 % of each are kept back."""

    damper: str
    model: DamperModel
    fit: tuple[Measurement, ...]
    unseen: tuple[Measurement, ...]


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
        help="processes that work (default: %(default)s, the number of cores)",
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


def read_cases(arguments: argparse.Namespace) -> list[Case]:
    """Every damper with its model and recordings.

    Raises:
        InputError: where a model, a recording or a measured force is missing.
    """
    signal_map = load_signal_map(arguments.signals)
    window = (arguments.start, arguments.stop)
    found = read(arguments.bags, signal_map, arguments.dampers, *window)
    models = {damper: load_model(arguments.model, damper) for damper in found}
    unseen = read(arguments.validate, signal_map, arguments.dampers, *window) if arguments.validate else {}
    for damper in found:
        if arguments.validate and damper not in unseen:
            progress(
                f"{damper}: in none of the recordings to judge on; the last 40 % of its own are kept back for that"
            )
    return [Case(damper, models[damper], tuple(own), tuple(unseen.get(damper, ()))) for damper, own in found.items()]


def check_places(*places: Path | str | None) -> None:
    """Tells before the work that results could not be written.

    Raises:
        InputError: where the folder of one of these files is missing.
    """
    for place in places:
        if place is not None and not Path(place).parent.is_dir():
            raise InputError(f"{place}: its folder does not exist; make it or choose another place")


def in_words(paths: Sequence[Path]) -> str:
    """Recordings for a title."""
    return paths[0].name if len(paths) == 1 else f"{len(paths)} recordings"
