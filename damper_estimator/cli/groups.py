"""Groups of recordings that the user names: ``--group NAME=BAG,...``."""

from collections.abc import Sequence
from pathlib import Path

from damper_estimator.errors import InputError


def parse_groups(given: Sequence[str], bags: Sequence[Path]) -> dict[str, tuple[str, ...]]:
    """Paths of the recordings of each group, as they stand in ``bags``.

    Args:
        given: such as ``comfort=slow.mcap,road.mcap``; a recording is named by its path, its file's name or its stem.
        bags: all recordings.

    Raises:
        InputError: for what is no group, a recording that is not among ``bags``, or one that is meant by several.
    """
    groups: dict[str, tuple[str, ...]] = {}
    for text in given:
        name, equals, members = text.partition("=")
        if not (name and equals and members):
            raise InputError(f"--group {text}: is no group; write NAME=BAG,BAG")
        if name in groups:
            raise InputError(f"--group {text}: {name} was given before; put all of its recordings into one")
        groups[name] = tuple(_recording(member, bags, text) for member in members.split(","))
    return groups


def _recording(member: str, bags: Sequence[Path], text: str) -> str:
    found = [path for path in bags if member in (str(path), path.name, path.stem)]
    if len(found) != 1:
        what = "is none of the recordings" if not found else "may be several of the recordings"
        raise InputError(f"--group {text}: {member} {what} ({', '.join(map(str, bags))})")
    return str(found[0])
