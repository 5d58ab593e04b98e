"""Writes files atomically (to a temporary file that replaces the target), formats JSON, reads YAML."""

import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from damper_estimator.errors import InputError, did_you_mean_file

_RECORDINGS = (b"\x89MCAP", b"SQLite format 3")  # how their files begin


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yields a temporary path next to ``path`` that replaces it if the block succeeds, and is removed if it fails.

    Raises:
        InputError: if the folder is missing or not writable.
    """
    target = Path(path)
    partial = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield partial
        os.replace(partial, target)
    except OSError as error:
        # An OSError about another file is left to the caller.
        if error.filename not in (None, str(partial), partial):
            raise
        raise InputError(f"{target}: cannot be written ({error.strerror}); choose another place with -o") from error
    finally:
        with suppress(OSError):
            partial.unlink()


def write_text(path: str | Path, text: str) -> None:
    """Writes a text file atomically.

    Raises:
        InputError: instead of replacing a recording, or a YAML file (a model, a signal map) by a page or JSON.
    """
    _check_kind(Path(path), text)
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _check_kind(target: Path, text: str) -> None:
    try:
        with target.open("rb") as stream:
            head = stream.read(len(max(_RECORDINGS, key=len)))
    except OSError:
        return
    if head.startswith(_RECORDINGS):
        raise InputError(f"{target}: is a recording and is kept; choose another file for the result")
    if target.suffix in (".yaml", ".yml") and text.lstrip()[:1] in ("{", "<"):
        raise InputError(f"{target}: is a YAML file and is kept; choose another file for a page or JSON")


def json_text(results: Mapping[str, object]) -> str:
    """Results as JSON; NaN and infinity become null, since JSON has neither."""
    return json.dumps(plain(results), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """The value in JSON's types; converts NumPy scalars and arrays, tuples and paths."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def read_yaml(path: str | Path) -> object:
    """The content of a YAML file, as data.

    Raises:
        InputError: if it cannot be read, or is not YAML.
    """
    try:
        return yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        remedy = (isinstance(error, FileNotFoundError) and did_you_mean_file(path)) or "; check the path"
        raise InputError(f"{path}: cannot be read ({error.strerror}){remedy}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f" at line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}: is not valid YAML{line}; correct the file") from error
