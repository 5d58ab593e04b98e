"""Checks before any work that its results can be written: a search of minutes must not end with "cannot be written"."""

import argparse
import errno
import os
from collections.abc import Iterator
from pathlib import Path

from damper_estimator.errors import InputError

STANDARD_OUTPUT = "-"
FILES = ("json", "html", "peaks", "fmu")  # arguments that name a file, in a folder that exists
PLACES = ("output", "c", "tables", "steps_dir", "signals_out")  # files, or folders that verbs create


def check_outputs(arguments: argparse.Namespace) -> None:
    """Checks the arguments of any verb that name what it writes.

    Raises:
        InputError: for a place that cannot be written, and where two results would have the same one.
    """
    seen: set[Path] = set()
    for path, is_file in _outputs(arguments):
        if path.resolve() in seen:
            raise InputError(f"{path}: is named for two results; give each its own file")
        seen.add(path.resolve())
        _check(path, is_file)


def _outputs(arguments: argparse.Namespace) -> Iterator[tuple[Path, bool]]:
    for name in (*FILES, *PLACES):
        value = getattr(arguments, name, None)
        if value and str(value) != STANDARD_OUTPUT:
            yield Path(value), name in FILES


def _check(path: Path, is_file: bool) -> None:
    if is_file and path.is_dir():
        raise InputError(f"{path}: is a folder; name a file in it")
    parent = path.parent
    if is_file and not parent.exists():
        raise InputError(f"{path}: cannot be written (there is no folder {parent}); create it first")
    nearest = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    folder = nearest.parent if nearest == path and path.is_file() else nearest
    if not folder.is_dir():
        reason = os.strerror(errno.ENOTDIR)
    elif not os.access(folder, os.W_OK | os.X_OK):
        reason = os.strerror(errno.EACCES)
    else:
        return
    raise InputError(f"{path}: cannot be created ({reason}); choose another place with -o")
