"""What several verbs share: arguments under the same names, JSON, progress."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damper_estimator.errors import InputError
from damper_estimator.files import json_text, write_text

if TYPE_CHECKING:
    from damper_estimator.workflows import Reader, Recording

STANDARD_OUTPUT = "-"


def add_bags(parser: argparse.ArgumentParser, several: bool = True) -> None:
    """``BAG...`` as ``arguments.bags`` (list of Path), or one ``BAG`` as ``arguments.bag``."""
    text = "a recording: an .mcap file or a rosbag2 folder"
    if several:
        parser.add_argument("bags", metavar="BAG", nargs="+", type=Path, help=text)
    else:
        parser.add_argument("bag", metavar="BAG", type=Path, help=text)


def add_models(parser: argparse.ArgumentParser, several: bool = False) -> None:
    """``-m MODEL`` as ``arguments.model`` (str), or repeated as ``arguments.models`` (list of str)."""
    text = "a model's name, a model file (YAML), or a folder with one DAMPER.yaml each"
    if several:
        text += "; may be repeated"
        parser.add_argument("-m", "--model", dest="models", metavar="MODEL", action="append", required=True, help=text)
    else:
        parser.add_argument("-m", "--model", metavar="MODEL", required=True, help=text)


def add_signals(parser: argparse.ArgumentParser) -> None:
    """``-s MAP.yaml`` as ``arguments.signals`` (Path or None) and ``-d NAME`` as ``arguments.dampers`` (list of
    str).
    """
    parser.add_argument(
        "-s", "--signals", metavar="MAP.yaml", type=Path, help="signal map; not needed for the default topics"
    )
    parser.add_argument(
        "-d", "--damper", dest="dampers", metavar="NAME", action="append", default=[],
        help="only this damper; may be repeated (default: all)",
    )  # fmt: skip


def add_window(parser: argparse.ArgumentParser) -> None:
    """``--from S`` and ``--to S`` as ``arguments.start`` and ``arguments.stop`` (float or None), seconds from the
    start.
    """
    parser.add_argument(
        "--from", dest="start", metavar="S", type=float, help="leave out what is before, s from the start"
    )
    parser.add_argument("--to", dest="stop", metavar="S", type=float, help="leave out what is after, s from the start")


def add_json(parser: argparse.ArgumentParser) -> None:
    """``--json FILE`` as ``arguments.json`` (str or None)."""
    parser.add_argument("--json", metavar="FILE", help="write the results as JSON; - is standard output")


def add_html(parser: argparse.ArgumentParser) -> None:
    """``--html FILE`` as ``arguments.html`` (Path or None)."""
    parser.add_argument("--html", metavar="FILE", type=Path, help="write one self-contained page with the figures")


def open_asked(arguments: argparse.Namespace) -> "AbstractContextManager[Reader]":
    """Opens ``arguments.bags`` by what ``add_signals`` and ``add_window`` declare, to read one damper at a time."""
    from damper_estimator.workflows import opened, signal_map_of

    signal_map = signal_map_of(arguments.signals)
    return opened(arguments.bags, signal_map, arguments.dampers, arguments.start, arguments.stop)


def read_asked(arguments: argparse.Namespace, bags: Sequence[Path] | None = None, whole: bool = False) -> "Recording":
    """Reads ``arguments.bags``, or other ``bags`` by the same map and dampers; the ``whole`` of them in place of the
    window."""
    from damper_estimator.workflows import read

    window = (None, None) if whole else (arguments.start, arguments.stop)
    return read(
        arguments.bags if bags is None else bags,
        signals=arguments.signals, dampers=arguments.dampers, start=window[0], stop=window[1],
    )  # fmt: skip


def check_places(*places: Path | str | None) -> None:
    """Tells before the work that results could not be written; ``-`` is standard output.

    Raises:
        InputError: where the folder of one of these files is missing.
    """
    for place in places:
        if place not in (None, STANDARD_OUTPUT) and not Path(place).parent.is_dir():
            raise InputError(f"{place}: its folder does not exist; make it or choose another place")


def progress(text: str) -> None:
    """Tells how the work goes, on standard error."""
    print(text, file=sys.stderr, flush=True)


def write_json(destination: str | None, results: Mapping[str, Any]) -> None:
    """Writes results as JSON to a file or to standard output (``-``); does nothing where no destination is given.

    NaN and infinite become null: JSON has neither.

    Raises:
        InputError: where the file cannot be written.
    """
    if destination is None:
        return
    text = json_text(results)
    if destination == STANDARD_OUTPUT:
        sys.stdout.write(text)
    else:
        write_text(destination, text)
