"""What is installed, in which version, and what cannot be used without the rest.

Looks at Python packages and extras, at the compiled kernels and where they are kept, at ROS 2 and the messages, and at
the programs that some verbs start. The exit status is 0 also where something is missing: most pieces are optional.

The first command that needs a kernel compiles it, which takes a few seconds for compare and fit, and up to half a
minute for diagnose, replay and the node. --warm compiles all that these use now, on all cores, and keeps it: once
after an installation, or while an image is built.
"""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby

from damper_estimator.cli.common import STANDARD_OUTPUT, add_json, progress, write_json
from damper_estimator.cli.doctor_checks import OK, Check, all_checks

EXAMPLES = (
    "doctor",
    "doctor --warm --json doctor.json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    parser.add_argument("--warm", action="store_true", help="compile the kernels, so that no later command has to")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Looks, prints, writes."""
    if arguments.warm:
        from damper_estimator.cli.warming import warm

        progress(f"compiled in {warm():.0f} s")
    checks = list(all_checks())
    if arguments.json != STANDARD_OUTPUT:
        print(table(checks))
    write_json(arguments.json, {"checks": [asdict(own) for own in checks], "unavailable": unavailable(checks)})
    return 0


def unavailable(checks: Sequence[Check]) -> dict[str, list[str]]:
    """What cannot be used here, and the names of the missing pieces."""
    found: dict[str, list[str]] = {}
    for own in checks:
        if own.state != OK:
            found.setdefault(own.needed, []).append(own.name)
    return found


def table(checks: Sequence[Check]) -> str:
    """All pieces by group, then what cannot be used."""
    width = max(len(own.name) for own in checks)
    lines = []
    for group, pieces in groupby(checks, key=lambda own: own.group):
        lines += [group, *(_line(own, width) for own in pieces)]
    missing = unavailable(checks)
    lines += ["", "cannot be used here:" if missing else "everything can be used here"]
    lines += [f"  {needed} (without {', '.join(names)})" for needed, names in missing.items()]
    return "\n".join(lines)


def _line(own: Check, width: int) -> str:
    text = f"  {own.state:<7}  {own.name:<{width}}  {own.found}"
    if own.state == OK:
        return text
    return f"{text}; needed for {own.needed}" + (f"; {own.remedy}" if own.remedy else "")
