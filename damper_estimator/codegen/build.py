"""Compiles generated C, if the machine has a C compiler: for binaries of FMUs, measured errors and tests."""

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from damper_estimator.errors import InputError

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic")


def find_compiler() -> str | None:
    """The C compiler: that of the environment variable CC, else cc, gcc or clang; None without a compiler."""
    names = (os.environ.get("CC", ""), "cc", "gcc", "clang")
    return next((found for name in names if name and (found := shutil.which(name))), None)


def build_library(
    sources: Sequence[Path], target: Path, compiler: str | None = None, flags: Sequence[str] = FLAGS
) -> None:
    """Compiles a shared library; ``target`` is its file.

    Raises:
        InputError: if no compiler is installed or it fails, with its message.
    """
    command = compiler or find_compiler()
    if command is None:
        raise InputError("no C compiler is installed (CC, cc, gcc or clang); install one")
    call = [command, *flags, "-shared", "-fvisibility=default", *map(str, sources), "-lm", "-o", str(target)]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"{' '.join(call)} failed: {(done.stderr.strip() or 'no message').splitlines()[0]}")
