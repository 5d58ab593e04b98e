"""Compiles the numerical kernels if numba is installed; without it the same functions run as plain Python.

Results are the same to the last few bits (numba's ``fastmath`` stays off); only the speed differs, by a factor of about
a hundred on blocks. ``NUMBA_DISABLE_JIT=1`` disables compilation.
"""

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

try:
    from numba import config, njit

    COMPILED = not config.DISABLE_JIT
except ImportError:
    COMPILED = False

_DISPATCHERS: list = []
"""Every compiled function, including those that are compiled at their first call."""
_UNDERWAY: dict = {}
"""By function, the process that compiles it in the background."""
_IMPORT = re.compile(r"^from (?P<module>damper_estimator[\w.]*) import (?P<names>\([^)]*\)|.*)", re.MULTILINE)


def _drop_stale_machine_code(package: Path) -> None:
    """Removes cached machine code older than any source file that it can depend on.

    numba checks only the file of the function itself and would miss an edited helper or constant in a file that it
    imports.
    """
    imports: dict[Path, tuple[Path, ...]] = {}
    for index in package.rglob("*.nbi"):
        source = index.parent.parent / f"{index.name.partition('.')[0]}.py"
        with suppress(OSError):
            if index.stat().st_mtime < max(path.stat().st_mtime for path in _reachable(source, package, imports)):
                index.unlink()


def _reachable(source: Path, package: Path, imports: dict[Path, tuple[Path, ...]]) -> set[Path]:
    """A source file and the files of the package that it imports, directly or through others."""
    reached, waiting = set(), [source]
    while waiting:
        path = waiting.pop()
        if path in reached:
            continue
        reached.add(path)
        if path not in imports:
            imports[path] = tuple(_imported(path.read_text(encoding="utf-8"), package))
        waiting += imports[path]
    return reached


def _imported(text: str, package: Path) -> Iterator[Path]:
    for found in _IMPORT.finditer(text):
        module, names = found["module"], re.findall(r"\w+", found["names"])
        for name in (module, *(f"{module}.{name}" for name in names)):
            path = package.parent.joinpath(*name.split("."))
            yield from (file for file in (path / "__init__.py", path.with_suffix(".py")) if file.is_file())


if COMPILED:
    _drop_stale_machine_code(Path(__file__).parent)


def _tolerating_full_disk(save: Callable) -> Callable:
    """A function that stores machine code, without an error if the disk is full."""

    def save_if_possible(*arguments: object) -> None:
        with suppress(OSError):
            save(*arguments)

    return save_if_possible


def compiled(function: Callable) -> Callable:
    """Decorator: the function in machine code, cached next to its file (or in the user's cache if that is
    read-only).
    """
    return _in_machine_code(function, "never")


def inlined(function: Callable) -> Callable:
    """As ``compiled``, for a small function that is called once per sample: it is inlined in its callers."""
    return _in_machine_code(function, "always")


def _in_machine_code(function: Callable, inline: str) -> Callable:
    if not COMPILED:
        return function
    try:
        dispatcher = njit(cache=True, error_model="numpy", inline=inline)(function)
    except RuntimeError:
        # A read-only installation without a home folder cannot store machine code, so every start compiles again.
        dispatcher = njit(error_model="numpy", inline=inline)(function)
    else:
        dispatcher._cache.save_overload = _tolerating_full_disk(dispatcher._cache.save_overload)
    _DISPATCHERS.append(dispatcher)
    return dispatcher


def is_kept(function: Callable) -> bool:
    """Whether machine code of a compiled function is kept from an earlier run."""
    folder, code = Path(function.stats.cache_path or ""), function.py_func.__code__
    name = f"{Path(code.co_filename).stem}.{function.py_func.__qualname__}-*"
    # numba writes the index before the code.
    return any(folder.glob(f"{name}.nbi")) and any(folder.glob(f"{name}.nbc"))


def compile_in_background(function: Callable, work: Callable[[], object]) -> None:
    """Compiles a function in another process, by ``work`` there, unless its machine code is kept from an earlier run.

    Does nothing on a single core. ``work`` is a function of a module; a new interpreter runs it, since a fork of a
    process with threads is unsafe.
    """
    if not COMPILED or (os.cpu_count() or 1) < 2 or function in _UNDERWAY or not sys.executable or is_kept(function):
        return
    code = f"import os, {work.__module__} as module; module.{work.__name__}(); os._exit(0)"  # without taking numba down
    paths = [str(Path(__file__).resolve().parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
    with suppress(OSError):
        _UNDERWAY[function] = subprocess.Popen(
            [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip


def wait_for(*functions: Callable) -> None:
    """Waits until functions that this process compiles in the background can be loaded."""
    for function in functions:
        process = _UNDERWAY.pop(function, None)
        if process is not None:
            process.wait()


def machine_code_folders() -> list[Path]:
    """Folders with the machine code of the modules imported so far; empty if nothing is compiled or stored."""
    return sorted({Path(dispatcher.stats.cache_path) for dispatcher in _DISPATCHERS if dispatcher.stats.cache_path})


if COMPILED:
    from numba.extending import intrinsic
    from numba.types import Array

    @intrinsic
    def borrowed(typing, arrays):
        """The same array, or tuple of arrays, without reference counting, which takes longer than a small kernel.

        Only for arguments of a compiled function, which its caller keeps alive.
        """

        def code(context, builder, signature, arguments):
            def uncounted(kind, value):
                given = context.make_array(kind)(context, builder, value)
                given.meminfo = given.meminfo.type(None)
                given.parent = given.parent.type(None)
                return given._getvalue()

            (kind,), (value,) = signature.args, arguments
            if isinstance(kind, Array):
                return uncounted(kind, value)
            parts = [uncounted(element, builder.extract_value(value, i)) for i, element in enumerate(kind)]
            return context.make_tuple(builder, kind, parts)

        return arrays(arrays), code

else:

    def borrowed(arrays):
        """The same array, or tuple of arrays."""
        return arrays


def plain(function: Callable) -> Callable:
    """The uncompiled function behind ``compiled``; tests compare the two."""
    return getattr(function, "py_func", function)
