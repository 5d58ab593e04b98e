"""The exception that users see as a single line, and its suggestions of similar names."""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path


class InputError(Exception):
    """The user's input cannot be used; the text states the file, the problem and the remedy.

    The command line prints it on one line and exits with status 1; the node refuses to start with it.
    Any other exception is a bug; the command line writes its traceback to a file and names that file.
    """

    def __init__(self, text: str) -> None:
        """``text`` may contain names from files: line breaks become blanks, unprintable characters escapes."""
        line = " ".join(part.strip() for part in text.splitlines())
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in line))


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``; did you mean a, b?`` with at most three known names similar to ``name``; empty if there are none."""
    near = get_close_matches(name, list(known), n=3, cutoff=0.6)
    return f"; did you mean {', '.join(near)}?" if near else ""


def did_you_mean_file(path: str | Path) -> str:
    """As ``did_you_mean``, for a missing file or folder, among those in the same folder."""
    path = Path(path)
    try:
        neighbours = sorted(entry.name for entry in path.parent.iterdir())
    except OSError:
        return ""
    return did_you_mean(path.name, neighbours)
