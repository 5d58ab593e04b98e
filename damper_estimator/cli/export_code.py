"""C and FMU for the verb export."""

import argparse
from math import isfinite

from damper_estimator.cli.common import STANDARD_OUTPUT
from damper_estimator.errors import InputError
from damper_estimator.workflows import to_c, to_fmu


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
    said: list[str] = []
    written: dict[str, object] = {"model": arguments.model}
    if len(arguments.dampers) > 1:
        raise InputError(f"{arguments.model}: one damper at a time; give -d once")
    common = {
        "name": arguments.name,
        "signals": arguments.signals,
        "damper": "".join(arguments.dampers),
        "cutoff": arguments.cutoff,
        "limits": arguments.limits,
        "lead": arguments.lead,
    }
    if arguments.c is not None:
        made = to_c(arguments.model, arguments.c, single=arguments.single, stale_after=arguments.stale_after, **common)
        said += [f"  {made.header}", f"  {made.source}", f"  {made.ram} bytes of state"]
        if arguments.single:
            said.append(f"  {_error_line(made.error)}")
        if made.without_inverse:
            said.append(f"  no inverse: {made.without_inverse}")
        written |= {"c": [made.header, made.source], "state_bytes": made.ram, "single_precision_error": made.error}
    if arguments.fmu is not None:
        unit = to_fmu(arguments.model, arguments.fmu, version=arguments.fmi, binary=not arguments.source_only, **common)
        said.append(f"  {unit.path}: FMI {arguments.fmi}, {'sources and binary' if unit.binary else 'sources only'}")
        if unit.untunable:
            said.append(f"  not tunable, as other numbers are prepared from them: {', '.join(unit.untunable)}")
        written |= {"fmu": unit.path, "binary": unit.binary, "untunable": list(unit.untunable)}
    if arguments.json != STANDARD_OUTPUT:
        print("\n".join([f"{arguments.model}:", *said]))
    return written


def _error_line(error: float) -> str:
    if isfinite(error):
        return f"single precision: the force differs by up to {error:.2g} of its largest value (a swept sine)"
    return "single precision: its error was not measured, there is no C compiler here"
