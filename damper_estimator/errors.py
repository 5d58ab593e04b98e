"""The one exception that reaches a user as a single line."""


class InputError(Exception):
    """The user's input cannot be used; the text says which file, what is wrong and what to do.

    The command line prints it on one line and exits with status 1; the node refuses to start with it.
    Anything else that is raised is a bug of ours; the command line writes its traceback to a file and names that file.
    """

    def __init__(self, text: str) -> None:
        """``text`` may hold names from files: line breaks become blanks, what else cannot be printed its escape."""
        line = " ".join(part.strip() for part in text.splitlines())
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in line))
