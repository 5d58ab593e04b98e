"""Check the installation: versions, missing parts, and features that are unavailable without them.

Checks Python packages and extras, compiled kernels and their cache, ROS 2 and the messages, and programs that some
verbs start. The exit status is 0 even if something is missing: most parts are optional.

The first command that needs a kernel compiles it, which takes a few seconds for compare and fit, and up to half a
minute for diagnose, replay and the node. --warm compiles and stores all kernels on all cores: use it once after an
installation, or while an image is built.
"""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby

from damper_estimator.cli.doctor_checks import OK, Check, all_checks
from damper_estimator.cli.verb_support import add_json, progress, write_results

EXAMPLES = (
    "doctor",
    "doctor --warm --json doctor.json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    parser.add_argument("--warm", action="store_true", help="compile the kernels in advance")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Runs the checks, prints and writes them."""
    if arguments.warm:
        from damper_estimator.cli.kernel_warmup import compile_kernels

        progress(f"compiled in {compile_kernels():.0f} s")
    checks = list(all_checks())
    results = {"checks": [asdict(check) for check in checks], "unavailable": unavailable(checks)}
    write_results(arguments, table(checks), results)
    return 0


def unavailable(checks: Sequence[Check]) -> dict[str, list[str]]:
    """Unavailable features with the names of the missing parts."""
    found: dict[str, list[str]] = {}
    for check in checks:
        if check.state != OK:
            found.setdefault(check.needed, []).append(check.name)
    return found


def table(checks: Sequence[Check]) -> str:
    """All parts by group, then unavailable features."""
    width = max(len(check.name) for check in checks)
    lines = []
    for group, pieces in groupby(checks, key=lambda check: check.group):
        lines += [group, *(_line(check, width) for check in pieces)]
    missing = unavailable(checks)
    lines += ["", "unavailable:" if missing else "everything is available"]
    lines += [f"  {needed} (without {', '.join(names)})" for needed, names in missing.items()]
    return "\n".join(lines)


def _line(check: Check, width: int) -> str:
    text = f"  {check.state:<7}  {check.name:<{width}}  {check.found}"
    if check.state == OK:
        return text
    return f"{text}; needed for {check.needed}" + (f"; {check.remedy}" if check.remedy else "")
