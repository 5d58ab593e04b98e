"""C and FMU for the verb export."""

import argparse
from hashlib import sha256
from math import isfinite
from pathlib import Path

from damper_estimator.cli.common import STANDARD_OUTPUT
from damper_estimator.codegen import Choices, write_c, write_fmu
from damper_estimator.errors import InputError
from damper_estimator.model import library_models, load_model
from damper_estimator.signals import load_signal_map


def add_code_arguments(parser: argparse._ArgumentGroup) -> None:
    """``--name``, ``--float`` and what the line needs to know."""
    parser.add_argument(
        "--name", metavar="NAME", default="", help="prefix of files and functions (default: the model's)"
    )
    parser.add_argument(
        "--float", dest="single", action="store_true", help="single precision; prints its error (C only)"
    )
    parser.add_argument(
        "--cutoff",
        metavar="HZ",
        type=float,
        help="of the filter, 0 for none (default: the map's, else the fit's, else 60)",
    )
    parser.add_argument(
        "--limits", metavar="LOW,HIGH", type=limits, help="of the command (default: the map's, else those of the fit)"
    )
    parser.add_argument("--lead", metavar="S", type=float, default=0.0, help="predict the motion ahead (%(default)g s)")
    parser.add_argument(
        "--stale-after", metavar="S", type=float, default=0.1, help="without a sample, until STALE (%(default)g s)"
    )
    parser.add_argument("--fmi", choices=("2.0", "3.0"), default="2.0", help="version of the FMU (%(default)s)")
    parser.add_argument(
        "--source-only", action="store_true", help="an FMU without a binary, for the importing program to compile"
    )


def limits(text: str) -> tuple[float, float]:
    """Two numbers separated by a comma."""
    low, high = (float(part) for part in text.split(","))
    return low, high


def write_code(arguments: argparse.Namespace) -> dict[str, object]:
    """Writes C and FMU; returns what goes to JSON."""
    model, choices = load_model(arguments.model), _choices(arguments)
    said: list[str] = []
    written: dict[str, object] = {"model": model.name}
    if arguments.c is not None:
        made = write_c(model, arguments.c, choices)
        said += [f"  {made.header}", f"  {made.source}", f"  {made.ram} bytes of state"]
        if choices.single:
            said.append(f"  {_error_line(made.error)}")
        if made.without_inverse:
            said.append(f"  no inverse: {made.without_inverse}")
        written |= {"c": [made.header, made.source], "state_bytes": made.ram, "single_precision_error": made.error}
    if arguments.fmu is not None:
        unit = write_fmu(model, arguments.fmu, choices, arguments.fmi, not arguments.source_only)
        said += [f"  {unit.path}: FMI {arguments.fmi}, {'sources and binary' if unit.binary else 'sources only'}"]
        if unit.untunable:
            said.append(f"  not tunable, as other numbers are prepared from them: {', '.join(unit.untunable)}")
        written |= {"fmu": unit.path, "binary": unit.binary, "untunable": list(unit.untunable)}
    if arguments.json != STANDARD_OUTPUT:
        print("\n".join([f"{model.name}:", *said]))
    return written


def _error_line(error: float) -> str:
    if isfinite(error):
        return f"single precision: the force differs by up to {error:.2g} of its largest value (swept sine of 10 s)"
    return "single precision: its error was not measured, there is no C compiler here"


def _choices(arguments: argparse.Namespace) -> Choices:
    signals = fusion = None
    cutoff = arguments.cutoff
    if arguments.signals is not None:
        whole = load_signal_map(arguments.signals)
        cutoff, fusion = whole.cutoff if cutoff is None else cutoff, whole.fusion
        signals = _signals(arguments, whole.dampers)
    return Choices(
        name=arguments.name, cutoff=cutoff, lead=arguments.lead, fusion=fusion, signals=signals,
        limits=arguments.limits, stale_after=arguments.stale_after, single=arguments.single,
        checksum=_checksum(arguments.model),
    )  # fmt: skip


def _signals(arguments: argparse.Namespace, dampers: dict):
    names = arguments.dampers or list(dampers)
    if len(names) != 1 or names[0] not in dampers:
        raise InputError(
            f"{arguments.signals}: choose one of its dampers with -d: {', '.join(dampers) or 'it has none'}"
        )
    return dampers[names[0]]


def _checksum(model: str) -> str:
    """SHA-256 of the model's file."""
    path = Path(model)
    path = path if path.exists() else library_models()[model]
    return sha256(path.read_bytes()).hexdigest()
