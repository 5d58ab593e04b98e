"""Compiles the numerical kernels where numba is installed; without it the same functions run as plain Python.

Results are the same to the last few bits (numba's ``fastmath`` stays off); only the speed differs, by a factor of about
a hundred on blocks. ``NUMBA_DISABLE_JIT=1`` switches compilation off where numba is installed.
"""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

try:
    from numba import config, njit

    COMPILED = not config.DISABLE_JIT
except ImportError:
    COMPILED = False


def _drop_stale_machine_code(package: Path) -> None:
    """Removes cached machine code older than the newest source file.

    numba looks only at the file of the function itself, so an edited helper in another file would go unnoticed.
    """
    newest = max(path.stat().st_mtime for path in package.rglob("*.py"))
    for index in package.rglob("*.nbi"):
        with suppress(OSError):
            if index.stat().st_mtime < newest:
                index.unlink()


if COMPILED:
    _drop_stale_machine_code(Path(__file__).parent)


def _where_there_is_room(save: Callable) -> Callable:
    """Saving of machine code that a full disk does not turn into an error of the computation."""

    def forgiving(*what: object) -> None:
        with suppress(OSError):
            save(*what)

    return forgiving


def compiled(function: Callable) -> Callable:
    """Decorator: the function in machine code, cached beside its file (or in the user's cache where that is
    read-only).
    """
    if not COMPILED:
        return function
    try:
        dispatcher = njit(cache=True, error_model="numpy")(function)
    except RuntimeError:
        # A read-only installation and no home folder: nowhere to keep machine code, so every start compiles anew.
        return njit(error_model="numpy")(function)
    dispatcher._cache.save_overload = _where_there_is_room(dispatcher._cache.save_overload)
    return dispatcher


def plain(function: Callable) -> Callable:
    """The uncompiled function behind ``compiled``; tests hold the two together."""
    return getattr(function, "py_func", function)
