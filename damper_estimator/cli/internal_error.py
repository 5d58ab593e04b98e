"""Reports an unexpected exception: details in a file, one line for the user."""

import os
import platform
import sys
import tempfile
import traceback
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

from damper_estimator import __version__


def internal_error(error: BaseException, words: Sequence[str]) -> str:
    """The line to print; the traceback goes to a file, or to standard error if no file can be written.

    Args:
        words: the command line after the program's name.
    """
    summary = f"internal error: {type(error).__name__}: {error}"
    details = "".join(traceback.format_exception(error))
    place = _written(
        f"damper_estimator {__version__}, Python {sys.version}, {platform.platform()}\n"
        f"damper-estimator {' '.join(map(repr, words))}\n\n{details}"
    )
    if place is None:
        print(details, file=sys.stderr)
        return f"{summary}; no file could be written, so the details are printed above; please send them"
    return f"{summary}; the details are in {place}; please send this file, and if possible the recording"


def _written(text: str) -> Path | None:
    """Writes the text to a file; None if no folder is writable."""
    name = f"error_{datetime.now(UTC):%Y-%m-%d_%H-%M-%S}_{os.getpid()}.txt"
    for folder in _folders():
        try:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8", errors="backslashreplace")
        except OSError:
            continue
        return folder / name
    return None


def _folders() -> Iterator[Path]:
    """Candidate folders: the user's folder for state, then the one for temporary files."""
    state = os.environ.get("XDG_STATE_HOME")
    if state:
        yield Path(state) / "damper_estimator"
    home = os.environ.get("HOME")
    if home:
        yield Path(home) / ".local" / "state" / "damper_estimator"
    try:
        yield Path(tempfile.gettempdir()) / "damper_estimator"
    except FileNotFoundError:  # none is writable
        return
