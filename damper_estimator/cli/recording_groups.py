"""Groups of recordings named by the user: ``--group NAME=BAG,...``."""

from collections.abc import Sequence
from pathlib import Path

from damper_estimator.errors import InputError


def parse_groups(given: Sequence[str], bags: Sequence[Path]) -> dict[str, tuple[str, ...]]:
    """Paths of the recordings of each group, as in ``bags``.

    Args:
        given: such as ``comfort=slow.mcap,road.mcap``; a recording is named by its path, its file's name or its stem.
        bags: all recordings.

    Raises:
        InputError: for an invalid group, a recording that is not among ``bags``, or an ambiguous name.
    """
    groups: dict[str, tuple[str, ...]] = {}
    for text in given:
        name, equals, members = text.partition("=")
        if not (name and equals and members):
            raise InputError(f"--group {text}: is not a group; write NAME=BAG,BAG")
        if name in groups:
            raise InputError(f"--group {text}: {name} is given twice; put all its recordings into one --group")
        groups[name] = tuple(_recording(member, bags, text) for member in members.split(","))
    return groups


def _recording(member: str, bags: Sequence[Path], text: str) -> str:
    found = [path for path in bags if member in (str(path), path.name, path.stem)]
    if len(found) != 1:
        problem = "is not one of the recordings" if not found else "matches several recordings"
        raise InputError(f"--group {text}: {member} {problem} ({', '.join(map(str, bags))})")
    return str(found[0])
