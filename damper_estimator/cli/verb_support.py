"""Shared by the verbs: common arguments, text and JSON output, pages, progress."""

import argparse
import math
import shlex
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damper_estimator.cli.output_check import STANDARD_OUTPUT
from damper_estimator.errors import InputError
from damper_estimator.files import json_text, write_text

if TYPE_CHECKING:
    from damper_estimator.workflows import Reader, Recording


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
        help="use only this damper; may be repeated (default: all)",
    )  # fmt: skip


def add_window(parser: argparse.ArgumentParser) -> None:
    """``--from S`` and ``--to S`` as ``arguments.start`` and ``arguments.stop`` (float or None), seconds from the
    start.
    """
    parser.add_argument(
        "--from", dest="start", metavar="S", type=float, help="ignore samples before this time, s from the start"
    )
    parser.add_argument(
        "--to", dest="stop", metavar="S", type=float, help="ignore samples after this time, s from the start"
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """``--json FILE`` as ``arguments.json`` (str or None)."""
    parser.add_argument("--json", metavar="FILE", help="write the results as JSON; - is standard output")


def add_html(parser: argparse.ArgumentParser) -> None:
    """``--html FILE`` as ``arguments.html`` (Path or None)."""
    parser.add_argument("--html", metavar="FILE", type=Path, help="write a self-contained page with the figures")


def add_reading(parser: argparse.ArgumentParser, html: bool = False) -> None:
    """The arguments of a verb that reads recordings: signal map, dampers, window, ``--json``, optionally ``--html``."""
    add_signals(parser)
    add_window(parser)
    add_json(parser)
    if html:
        add_html(parser)


def at_least(least: int) -> Callable[[str], int]:
    """A type of argument: whole numbers from ``least`` on."""

    def number(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least {least}")
        return int(text)

    return number


def finite(text: str) -> float:
    """A type of argument: any number but NaN and infinity."""
    return _number(text, lambda value: True, "a finite number")


def from_zero(text: str) -> float:
    """A type of argument: a finite number that is not negative."""
    return _number(text, lambda value: value >= 0.0, "a finite number of at least 0")


def above_zero(text: str) -> float:
    """A type of argument: a finite number greater than 0."""
    return _number(text, lambda value: value > 0.0, "a finite number above 0")


def _number(text: str, allowed: Callable[[float], bool], wanted: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and allowed(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not {wanted}")
    return value


@contextmanager
def optional_packages(user: str, extra: str, modules: Collection[str]) -> Iterator[None]:
    """Reports a missing optional package by name when the block imports it.

    Args:
        user: what requires it, for the message.
        extra: of damper_estimator, that installs it.
        modules: top-level names that may be missing.

    Raises:
        InputError: if one of them is missing.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in modules:
            raise
        raise InputError(
            f"{user} needs {error.name}, which is not installed: pip install 'damper_estimator[{extra}]'"
        ) from error


def open_recordings(arguments: argparse.Namespace) -> "AbstractContextManager[Reader]":
    """Opens ``arguments.bags`` with the arguments of ``add_signals`` and ``add_window``, to read damper by damper."""
    from damper_estimator.workflows import open_reader, signal_map_of

    signal_map = signal_map_of(arguments.signals)
    return open_reader(arguments.bags, signal_map, arguments.dampers, arguments.start, arguments.stop)


def read_recordings(
    arguments: argparse.Namespace, bags: Sequence[Path] | None = None, whole: bool = False
) -> "Recording":
    """Reads ``arguments.bags``, or other ``bags`` with the same map and dampers; ``whole`` ignores the window."""
    from damper_estimator.workflows import read

    window = (None, None) if whole else (arguments.start, arguments.stop)
    return read(
        arguments.bags if bags is None else bags,
        signals=arguments.signals, dampers=arguments.dampers, start=window[0], stop=window[1],
    )  # fmt: skip


def reading_words(arguments: argparse.Namespace) -> list[str]:
    """The options of ``add_signals`` and ``add_window`` as they were given."""
    words = ["-s", str(arguments.signals)] if arguments.signals else []
    words += [word for damper in arguments.dampers or () for word in ("-d", damper)]
    for option, value in (("--from", arguments.start), ("--to", arguments.stop)):
        words += [option, str(value)] if value is not None else []
    return words


def command(*words: object) -> str:
    """A command of this program for a shell."""
    return shlex.join(["damper-estimator", *map(str, words)])


def check_output_folders(*places: Path | str | None) -> None:
    """Checks before the work that results can be written; ``-`` is standard output.

    Raises:
        InputError: if the folder of one of these files is missing.
    """
    for place in places:
        if place not in (None, STANDARD_OUTPUT) and not Path(place).parent.is_dir():
            raise InputError(f"{place}: its folder does not exist; create it or choose another one")


def progress(text: str) -> None:
    """Prints a line about the progress on standard error."""
    print(text, file=sys.stderr, flush=True)


def report_notes(notes: Iterable[str]) -> None:
    """Prints notes, such as omissions, on standard error."""
    for note in notes:
        progress(note)


def prints_text(arguments: argparse.Namespace) -> bool:
    """Whether results are printed as text: not if JSON goes to standard output."""
    return arguments.json != STANDARD_OUTPUT


def write_results(arguments: argparse.Namespace, text: str, results: Mapping[str, Any]) -> None:
    """Prints results as text, unless JSON goes to standard output, and writes them as JSON if requested."""
    if prints_text(arguments):
        print(text)
    write_json(arguments.json, results)


def write_page(path: Path, page: str) -> None:
    """Writes a page and reports it."""
    write_text(path, page)
    progress(f"wrote {path}")


def write_json(destination: str | None, results: Mapping[str, Any]) -> None:
    """Writes results as JSON to a file or to standard output (``-``); does nothing without a destination.

    NaN and infinity become null, since JSON has neither.

    Raises:
        InputError: if the file cannot be written.
    """
    if destination is None:
        return
    text = json_text(results)
    if destination == STANDARD_OUTPUT:
        sys.stdout.write(text)
    else:
        write_text(destination, text)
