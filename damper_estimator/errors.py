"""The one exception that reaches a user as a single line, and the hint that it may give."""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path


class InputError(Exception):
    """The user's input cannot be used; the text says which file, what is wrong and what to do.

    The command line prints it on one line and exits with status 1; the node refuses to start with it.
    Anything else that is raised is a bug of ours; the command line writes its traceback to a file and names that file.
    """

    def __init__(self, text: str) -> None:
        """``text`` may hold names from files: line breaks become blanks, what else cannot be printed its escape."""
        line = " ".join(part.strip() for part in text.splitlines())
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in line))


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``; did you mean a, b?`` with at most three known names that are near to ``name``; empty where none is."""
    near = get_close_matches(name, list(known), n=3, cutoff=0.6)
    return f"; did you mean {', '.join(near)}?" if near else ""


def did_you_mean_file(path: str | Path) -> str:
    """The same for a file or folder that does not exist, among those beside it."""
    path = Path(path)
    try:
        beside = sorted(entry.name for entry in path.parent.iterdir())
    except OSError:
        return ""
    return did_you_mean(path.name, beside)
