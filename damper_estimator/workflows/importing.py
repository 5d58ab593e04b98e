"""Bench and logger files (CSV, text, MAT) to recordings, by a column map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings import Part, load_column_maps, planned_paths, read_parts, write_part


@dataclass(frozen=True)
class Imported:
    """A part of a bench file and the recording that is made of it."""

    part: Part
    path: Path

    def record(self) -> dict[str, object]:
        """For JSON: ranges in the units that the bag holds."""
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
    paths: Sequence[Path], columns: str | Path, output: Path, tell: Callable[[str], None]
) -> tuple[Imported, ...]:
    """Reads every file before it writes the first recording, so that a bad one leaves nothing behind.

    Args:
        columns: column map: a file, or the name of one in ``config/columns``.
        output: a folder, or an ``.mcap`` file for a single part.
        tell: receives a line per file.

    Raises:
        InputError: for files and maps that cannot be used, and where a recording cannot be written.
    """
    maps = load_column_maps(columns)
    parts: list[Part] = []
    templates: list[str | None] = []
    for path in paths:
        rules = maps.for_file(path.name)
        found = read_parts(path, rules)
        tell(f"{path}: {len(found)} part{'s' if len(found) > 1 else ''}")
        parts += found
        templates += [rules.name] * len(found)
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
        raise InputError(f"{output}: cannot be made ({error.strerror}); choose another folder with -o") from error
