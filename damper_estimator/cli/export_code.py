"""The parts of the verb export that write C and FMU."""

import argparse
from math import isfinite

from damper_estimator.cli.verb_support import above_zero, from_zero, prints_text
from damper_estimator.errors import InputError
from damper_estimator.workflows import to_c, to_fmu


def add_code_arguments(parser: argparse._ArgumentGroup) -> None:
    """``--name``, ``--float`` and the options of the line."""
    parser.add_argument(
        "--name", metavar="NAME", default="", help="prefix of files and functions (default: the model's)"
    )
    parser.add_argument(
        "--float", dest="single", action="store_true", help="single precision; prints its error (C only)"
    )
    parser.add_argument(
        "--cutoff",
        metavar="HZ",
        type=from_zero,
        help="cutoff of the filter, 0 for none (default: that of the map, else of the fit, else 60)",
    )
    parser.add_argument(
        "--limits",
        metavar="LOW,HIGH",
        type=limits,
        help="limits of the command (default: those of the map, else of the fit)",
    )
    parser.add_argument(
        "--lead", metavar="S", type=from_zero, default=0.0, help="predict the motion ahead (%(default)g s)"
    )
    parser.add_argument(
        "--stale-after", metavar="S", type=above_zero, default=0.1,
        help="time without a sample until STALE (%(default)g s)",
    )  # fmt: skip
    parser.add_argument("--fmi", choices=("2.0", "3.0"), default="2.0", help="version of the FMU (%(default)s)")
    parser.add_argument(
        "--source-only", action="store_true", help="an FMU without a binary, to be compiled by the importing program"
    )


def limits(text: str) -> tuple[float, float]:
    """Two numbers separated by a comma."""
    low, high = (float(part) for part in text.split(","))
    return low, high


def write_code(arguments: argparse.Namespace) -> dict[str, object]:
    """Writes C and FMU; returns their results for JSON."""
    lines: list[str] = []
    written: dict[str, object] = {"model": arguments.model}
    if len(arguments.dampers) > 1:
        raise InputError(f"{arguments.model}: one damper at a time; use -d once")
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
        lines += [f"  {made.header}", f"  {made.source}", f"  {made.ram} bytes of state"]
        if arguments.single:
            lines.append(f"  {_error_line(made.error)}")
        if made.without_inverse:
            lines.append(f"  no inverse: {made.without_inverse}")
        written |= {"c": [made.header, made.source], "state_bytes": made.ram, "single_precision_error": made.error}
    if arguments.fmu is not None:
        unit = to_fmu(arguments.model, arguments.fmu, version=arguments.fmi, binary=not arguments.source_only, **common)
        lines.append(f"  {unit.path}: FMI {arguments.fmi}, {'sources and binary' if unit.binary else 'sources only'}")
        if unit.untunable:
            lines.append(f"  not tunable, because other values are computed from them: {', '.join(unit.untunable)}")
        written |= {"fmu": unit.path, "binary": unit.binary, "untunable": list(unit.untunable)}
    if prints_text(arguments):
        print("\n".join([f"{arguments.model}:", *lines]))
    return written


def _error_line(error: float) -> str:
    if isfinite(error):
        return f"single precision: the force differs by up to {error:.2g} of its largest value (a swept sine)"
    return "single precision: its error was not measured, since there is no C compiler"
