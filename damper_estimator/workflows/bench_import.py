"""Imports bench and logger files (CSV, text, MAT) as recordings with a column map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.recordings import (
    Guess,
    Part,
    column_map_of,
    guess_columns,
    load_column_maps,
    planned_paths,
    read_parts,
    write_part,
)
from damper_estimator.report import import_page


@dataclass(frozen=True)
class Imported:
    """A part of a bench file and the recording made from it."""

    part: Part
    path: Path

    def record(self) -> dict[str, object]:
        """For JSON: ranges in the units of the recording."""
        part = self.part
        return {
            "file": self.path,
            "source": part.source,
            "part": part.number,
            "samples": len(part.stamps),
            "rate_hz": part.rate,
            "duration_s": part.duration,
            "dampers": {
                damper: {
                    name: {"min": np.nanmin(values), "max": np.nanmax(values), "unit": part.units[damper][name]}
                    for name, values in channels.items()
                }
                for damper, channels in part.dampers.items()
            },
            "notes": part.notes,
        }


def import_files(
    paths: Sequence[Path], columns: str | Path, output: Path, progress: Callable[[str], None]
) -> tuple[Imported, ...]:
    """Reads every file before it writes the first recording, so that an unusable file leaves no output.

    Args:
        columns: column map: a file, or the name of one in ``config/columns``.
        output: a folder, or an ``.mcap`` file for a single part.
        progress: receives a line per file.

    Raises:
        InputError: for unusable files and maps, and if a recording cannot be written.
    """
    maps = load_column_maps(columns)
    parts: list[Part] = []
    templates: list[str | None] = []
    for path in paths:
        rules = maps.for_file(path.name)
        found = read_parts(path, rules)
        progress(f"{path}: {len(found)} part{'s' if len(found) > 1 else ''}")
        parts += found
        templates += [rules.name] * len(found)
    return _written(parts, templates, output)


@dataclass(frozen=True)
class Guessed:
    """A bench file whose column map was guessed.

    Attributes:
        columns, page: files with the map and its preview.
        parts: read with the guessed map; empty if that fails.
    """

    guess: Guess
    columns: Path
    page: Path
    parts: tuple[Part, ...]


def guess_files(paths: Sequence[Path], output: Path) -> tuple[Guessed, ...]:
    """Guesses the column map of each file and writes it next to ``output``, with a preview page.

    Raises:
        InputError: for unreadable files, if the output cannot be written, and if a map there differs from the guess.
    """
    folder = output.parent if output.suffix == ".mcap" else output
    _make_folder(output)
    found = []
    for path in paths:
        guess = guess_columns(path)
        parts = _readable(guess)
        columns, page = (folder / f"{path.stem}_{name}" for name in ("columns.yaml", "preview.html"))
        _check_unchanged(columns, guess.map_text())
        write_text(columns, guess.map_text())
        write_text(page, import_page(guess, parts))
        found.append(Guessed(guess, columns, page, parts))
    return tuple(found)


def _check_unchanged(columns: Path, text: str) -> None:
    """A map that was corrected by hand is kept."""
    if columns.exists() and columns.read_text(encoding="utf-8") != text:
        raise InputError(
            f"{columns}: differs from what is guessed now, and is kept; import with --columns {columns}, or remove it "
            "to guess again"
        )


def import_guessed(guessed: Sequence[Guessed], output: Path) -> tuple[Imported, ...]:
    """Writes the recordings of guessed files.

    Raises:
        InputError: for doubtful guesses (the text names the map to be corrected), and if the output cannot be written.
    """
    doubted = [file for file in guessed if file.guess.doubts]
    if doubted:
        first = doubted[0]
        doubts = "; ".join(first.guess.doubts)
        remedy = f"check {first.page}, correct {first.columns}, and import with --columns {first.columns}"
        raise InputError(f"{first.guess.path}: not imported: {doubts}; {remedy}")
    parts = [part for file in guessed for part in file.parts]
    return _written(parts, [None] * len(parts), output)


def _readable(guess: Guess) -> tuple[Part, ...]:
    try:
        return tuple(read_parts(guess.path, column_map_of(guess.content(), str(guess.path))))
    except InputError:
        return ()


def _written(parts: list[Part], templates: list[str | None], output: Path) -> tuple[Imported, ...]:
    targets = planned_paths(parts, templates, output)
    _make_folder(output)
    for part, path in zip(parts, targets, strict=True):
        write_part(part, path)
    return tuple(Imported(part, path) for part, path in zip(parts, targets, strict=True))


def _make_folder(output: Path) -> None:
    if output.suffix == ".mcap":
        return
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{output}: cannot be created ({error.strerror}); choose another folder with -o") from error
