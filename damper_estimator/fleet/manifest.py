"""Finds the recordings of a fleet: from a manifest (YAML or CSV), patterns, or paths.

A manifest names for each recording its ``vehicle``, ``dampers``, signal map (``signals``) and ``model``; only
``recording`` is required, and it may be a pattern. Paths are relative to the manifest. Without a manifest the
vehicle of a recording is the name of its folder.

    recordings:
      - {recording: "car_7/*.mcap", vehicle: car 7, dampers: [front_left], signals: maps/car_7.yaml}
"""

import csv
import glob
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.files import read_yaml

KEYS = ("recording", "vehicle", "dampers", "signals", "model")
_MANIFESTS = (".yaml", ".yml", ".csv")


@dataclass(frozen=True)
class Recording:
    """One recording of the fleet.

    Attributes:
        path: absolute.
        vehicle: its name.
        dampers: names to use; empty for all.
        signals: path of its signal map, "" for the default topics.
        model: of this recording; "" for the model that applies to all.
    """

    path: str
    vehicle: str
    dampers: tuple[str, ...] = ()
    signals: str = ""
    model: str = ""


def find_recordings(
    sources: Sequence[str], dampers: Sequence[str] = (), signals: Path | None = None
) -> tuple[Recording, ...]:
    """All recordings that the sources name, sorted by path.

    Args:
        sources: manifests, patterns with ``*``, ``?``, ``[`` or ``**``, and recordings.
        dampers, signals: of recordings for which no manifest says otherwise.

    Raises:
        InputError: for an unusable manifest, a pattern that matches nothing, a recording that is named twice.
    """
    default_dampers, map_path = tuple(dampers), "" if signals is None else str(signals.absolute())
    found: dict[str, Recording] = {}
    for source in sources:
        entries = _manifest(Path(source)) if source.lower().endswith(_MANIFESTS) else [(Path(), {"recording": source})]
        for folder, entry in entries:
            for path in _matching(str(entry["recording"]), folder, source):
                if str(path) in found:
                    raise InputError(f"{source}: names {path} twice; name each recording once")
                wanted_dampers = tuple(entry.get("dampers") or default_dampers)
                own_map = str((folder / entry["signals"]).absolute()) if entry.get("signals") else map_path
                vehicle = str(entry.get("vehicle") or path.parent.name)
                model = _model(entry.get("model"), folder)
                found[str(path)] = Recording(str(path), vehicle, wanted_dampers, own_map, model)
    return tuple(found[path] for path in sorted(found))


def _model(named: object, folder: Path) -> str:
    """A model's path relative to the manifest if that file exists, else the name of a library model."""
    if not named:
        return ""
    path = (folder / str(named)).absolute()
    return str(path) if path.exists() else str(named)


def _matching(pattern: str, folder: Path, source: str) -> Iterator[Path]:
    """Recordings that match a pattern; a path without wildcards need not exist."""
    place = folder / pattern
    if not glob.has_magic(pattern):
        yield place.absolute()
        return
    found = [Path(name).absolute() for name in glob.glob(str(place), recursive=True)]
    found = sorted(path for path in found if path.suffix == ".mcap" or (path / "metadata.yaml").is_file())
    # Files inside a recording folder are not separate recordings.
    folders = {path for path in found if path.is_dir()}
    found = [path for path in found if path.is_dir() or not folders & set(path.parents)]
    if not found:
        raise InputError(
            f"{source}: no recording (.mcap file or rosbag2 folder) matches {pattern}; correct the pattern"
        )
    yield from found


def _manifest(path: Path) -> list[tuple[Path, Mapping[str, object]]]:
    """The entries of a manifest, each with the folder to which its paths are relative."""
    entries = _csv_entries(path) if path.suffix.lower() == ".csv" else _yaml_entries(path)
    for number, entry in enumerate(entries, 1):
        unknown = [str(key) for key in entry if key not in KEYS]
        if unknown:
            raise InputError(f"{path}: entry {number} has {', '.join(unknown)}; allowed are {', '.join(KEYS)}")
        if not entry.get("recording"):
            raise InputError(f"{path}: entry {number} names no recording")
        if not isinstance(entry.get("dampers") or [], list):
            raise InputError(f"{path}: entry {number}: dampers {entry['dampers']!r} is not a list; write [NAME, NAME]")
    if not entries:
        raise InputError(f"{path}: names no recording; write a list under 'recordings'")
    return [(path.parent, entry) for entry in entries]


def _yaml_entries(path: Path) -> list[Mapping[str, object]]:
    content = read_yaml(path)
    listed = content.get("recordings") if isinstance(content, Mapping) else content
    if not isinstance(listed, list) or not all(isinstance(entry, (Mapping, str)) for entry in listed):
        raise InputError(f"{path}: is not a manifest; it needs a list of recordings under 'recordings'")
    return [{"recording": entry} if isinstance(entry, str) else entry for entry in listed]


def _csv_entries(path: Path) -> list[Mapping[str, object]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file, restkey="more"))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{path}: cannot be read ({reason}); check the path") from error
    return [row | {"dampers": (row.get("dampers") or "").replace(";", " ").split()} for row in rows]
