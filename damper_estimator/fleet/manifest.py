"""Which recordings there are: a manifest (YAML or CSV), patterns, or recordings themselves.

A manifest names for each recording its ``vehicle``, ``dampers``, signal map (``signals``) and ``model``; only
``recording`` must be there, and it may be a pattern. Paths are relative to the manifest. Without a manifest a
recording belongs to the vehicle that its folder is named after.

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
        dampers: which are wanted; empty for all it has.
        signals: path of its signal map, "" for the default topics.
        model: its own, "" for the one that is given for all.
    """

    path: str
    vehicle: str
    dampers: tuple[str, ...] = ()
    signals: str = ""
    model: str = ""


def find_recordings(
    sources: Sequence[str], dampers: Sequence[str] = (), signals: Path | None = None
) -> tuple[Recording, ...]:
    """All recordings that sources mean, sorted by path.

    Args:
        sources: manifests, patterns with ``*``, ``?``, ``[`` or ``**``, and recordings.
        dampers, signals: of those recordings for which no manifest says otherwise.

    Raises:
        InputError: for a manifest that cannot be used, a pattern that means nothing, a recording that is named twice.
    """
    wanted, map_path = tuple(dampers), "" if signals is None else str(signals.absolute())
    found: dict[str, Recording] = {}
    for source in sources:
        entries = _manifest(Path(source)) if source.lower().endswith(_MANIFESTS) else [(Path(), {"recording": source})]
        for folder, entry in entries:
            for path in _matching(str(entry["recording"]), folder, source):
                if str(path) in found:
                    raise InputError(f"{source}: names {path} twice; a recording is worked on once")
                own = tuple(entry.get("dampers") or wanted)
                mine = str((folder / entry["signals"]).absolute()) if entry.get("signals") else map_path
                vehicle = str(entry.get("vehicle") or path.parent.name)
                model = _model(entry.get("model"), folder)
                found[str(path)] = Recording(str(path), vehicle, own, mine, model)
    return tuple(found[path] for path in sorted(found))


def _model(named: object, folder: Path) -> str:
    """A model's path relative to the manifest where such a file is there, else a name of the library."""
    if not named:
        return ""
    path = (folder / str(named)).absolute()
    return str(path) if path.exists() else str(named)


def _matching(pattern: str, folder: Path, source: str) -> Iterator[Path]:
    """Recordings of a pattern; a path without wildcards is a recording, there or not."""
    place = folder / pattern
    if not glob.has_magic(pattern):
        yield place.absolute()
        return
    found = [Path(name).absolute() for name in glob.glob(str(place), recursive=True)]
    found = sorted(path for path in found if path.suffix == ".mcap" or (path / "metadata.yaml").is_file())
    # The files of a recording that is a folder are no recordings of their own.
    folders = {path for path in found if path.is_dir()}
    found = [path for path in found if path.is_dir() or not folders & set(path.parents)]
    if not found:
        raise InputError(
            f"{source}: no recording (.mcap file or rosbag2 folder) matches {pattern}; correct the pattern"
        )
    yield from found


def _manifest(path: Path) -> list[tuple[Path, Mapping[str, object]]]:
    """The entries of a manifest, each with the folder that its paths are relative to."""
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
