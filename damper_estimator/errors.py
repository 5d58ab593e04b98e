"""The one exception that reaches a user as a single line."""


class InputError(Exception):
    """The user's input cannot be used; the text says which file, what is wrong and what to do.

    The command line prints it on one line and exits with status 1; the node refuses to start with it.
    Anything else that is raised is a bug of ours and keeps its traceback.
    """
