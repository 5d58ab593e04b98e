"""The storage files of a recording: a single file, or a rosbag2 folder with its ``metadata.yaml``."""

import shutil
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import yaml
import zstandard

from damper_estimator.errors import InputError, did_you_mean_file
from damper_estimator.recordings import mcap_file, sqlite_file
from damper_estimator.recordings.library_errors import explained
from damper_estimator.recordings.mcap_file import McapFile
from damper_estimator.recordings.sqlite_file import SqliteFile

_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_KEY = "rosbag2_bagfile_information"
_GIVE = "; give an .mcap file or a rosbag2 folder"


@dataclass(frozen=True)
class Contents:
    """The storage files of a recording in order, and whether each message is compressed separately (zstd)."""

    files: tuple[Path, ...]
    compressed_messages: bool


def contents_of(path: Path) -> Contents:
    """Finds the storage files of an ``.mcap`` or ``.db3`` file or a rosbag2 folder.

    Raises:
        InputError: if the path does not exist, is no recording, or a file of it is missing.
    """
    with explained(path, "give an .mcap file or a rosbag2 folder"):
        if path.is_file():
            return Contents((path,), False)
        if not path.is_dir():
            raise InputError(f"{path}: does not exist{did_you_mean_file(path) or _GIVE}")
        names = sorted(entry.name for entry in path.iterdir())
    if "metadata.yaml" not in names:
        raise InputError(_no_metadata(path, names))
    return _from_metadata(path, path / "metadata.yaml")


def _no_metadata(path: Path, names: list[str]) -> str:
    storage = [name for name in names if name.endswith((".mcap", ".db3", ".db3.zstd", ".mcap.zstd"))]
    if not storage:
        return f"{path}: no rosbag2 folder (metadata.yaml is missing); give an .mcap file or a rosbag2 folder"
    remedy = f"write it with: ros2 bag reindex {path} (or give one file: {', '.join(storage)})"
    return f"{path}: metadata.yaml is missing; {remedy}"


def _from_metadata(folder: Path, metadata: Path) -> Contents:
    remedy = f"write it again with: ros2 bag reindex {folder}"
    with explained(metadata, remedy):
        information = yaml.load(metadata.read_text(encoding="utf-8"), getattr(yaml, "CSafeLoader", yaml.SafeLoader))[
            _KEY
        ]
        # Old versions put a folder before the name, sometimes a wrong one; the files are next to the metadata.
        files = tuple(folder / PurePosixPath(str(name)).name for name in information["relative_file_paths"])
        mode = str(information.get("compression_mode") or "").upper()
        compression = str(information.get("compression_format") or "zstd")
    missing = [path.name for path in files if not path.is_file()]
    if missing:
        raise InputError(f"{folder}: {', '.join(missing)} is missing; copy it next to metadata.yaml, or {remedy}")
    if mode not in ("", "NONE") and compression != "zstd":
        raise InputError(
            f"{folder}: compressed with {compression!r}; only zstd can be read, convert with: ros2 bag convert"
        )
    return Contents(files, mode == "MESSAGE")


def open_storage(path: Path, scratch: Path) -> McapFile | SqliteFile:
    """Opens one storage file by its content, not its name; a zstd file is unpacked into ``scratch`` first.

    Raises:
        InputError: if it is empty, damaged or no storage file.
    """
    with explained(path, "copy it again"):
        with open(path, "rb") as file:
            magic = file.read(16)
        if magic.startswith(_ZSTD_MAGIC):
            return _open_plain(_unpacked(path, scratch), str(path))
    return _open_plain(path, str(path), magic)


def _unpacked(path: Path, scratch: Path) -> Path:
    target = scratch / path.stem
    with open(path, "rb") as packed, open(target, "wb") as plain, zstandard.open(packed, "rb") as unpacking:
        shutil.copyfileobj(unpacking, plain, 1 << 20)
    return target


def _open_plain(path: Path, name: str, magic: bytes | None = None) -> McapFile | SqliteFile:
    if magic is None:
        with open(path, "rb") as file:
            magic = file.read(16)
    if magic.startswith(mcap_file.MAGIC):
        return McapFile(path, name)
    if magic.startswith(sqlite_file.MAGIC):
        return SqliteFile(path, name)
    if not magic:
        raise InputError(f"{name}: empty; record or copy it again")
    raise InputError(
        f"{name}: neither mcap nor sqlite3; give an .mcap file or a rosbag2 folder (import turns text into one)"
    )
