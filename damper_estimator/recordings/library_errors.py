"""Turns the errors of libraries on unusable files into one line for the user."""

import sqlite3
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

import yaml

from damper_estimator.errors import InputError, did_you_mean_file


def _error_of(module: str, name: str) -> tuple[type[Exception], ...]:
    """An error class of a library; none if the library is not installed, because then nothing raises it."""
    try:
        return (getattr(import_module(module), name),)
    except ModuleNotFoundError:
        return ()


# Bytes that are no bag make the libraries raise all of these (found by fuzzing).
LIBRARY_ERRORS: tuple[type[Exception], ...] = (
    *_error_of("mcap.exceptions", "McapError"),
    *_error_of("zstandard", "ZstdError"),
    sqlite3.Error,
    yaml.YAMLError,
    struct.error,
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    RuntimeError,
    TypeError,
    ValueError,
    zlib.error,
)


@contextmanager
def explained(path: str | Path, remedy: str) -> Iterator[None]:
    """Raises an `InputError` that names ``path`` for any error of a library inside the block.

    Keep the block to library calls: inside it our bugs would be blamed on the user's file.
    """
    try:
        yield
    except OSError as error:
        hint = (isinstance(error, FileNotFoundError) and did_you_mean_file(path)) or "; check the path and its rights"
        raise InputError(f"{path}: cannot be read ({error.strerror or error}){hint}") from error
    except LIBRARY_ERRORS as error:
        raise InputError(f"{path}: damaged ({one_line(error)[:160]}); {remedy}") from error


def one_line(text: object) -> str:
    """Text from a file (names, library messages) without line breaks, for a one-line message."""
    return " ".join(str(text).split()) or type(text).__name__
