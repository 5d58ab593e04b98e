"""Files that are dropped on the page: written to a temporary file and moved into place, never over another file."""

import os
import shutil
import zipfile
import zlib
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path, PurePosixPath
from typing import IO

from damper_estimator.errors import InputError
from damper_estimator.studio.folder import BENCH, YAML, Folder, Taken

STORAGE = (".mcap", ".db3", ".zstd")
ACCEPTED = (*STORAGE, *BENCH, *YAML, ".zip")
SPARE = 500_000_000  # bytes that are left free on the disk
_MOST_MEMBERS = 1000
_BLOCK = 1 << 20


def receive(folder: Folder, name: str, stream: IO[bytes], length: int) -> str:
    """Writes a file that a page sends; a zipped rosbag2 folder is unpacked.

    Args:
        name: relative to the folder; the file of a folder that was dropped has the folder's name before it.
        stream, length: what is sent, and its size in bytes.

    Returns:
        what was added.

    Raises:
        Taken: where there is a file of that name.
        InputError: for other names and kinds of files, what does not fit on the disk, and what ends too early.
    """
    target = _place(folder, name)
    if length > shutil.disk_usage(folder.root).free - SPARE:
        raise InputError(f"{name}: {length / 1e9:.1f} GB do not fit on the disk")
    if target.suffix == ".zip" and target.with_suffix("").exists():
        raise Taken(f"{name}: {target.stem} exists already; rename one of them")
    _written(target, partial(_copied, name, stream, length=length))
    if target.suffix != ".zip":
        return name
    try:
        return _unpacked(folder, target)
    finally:
        target.unlink()


def _place(folder: Folder, name: str) -> Path:
    suffix = PurePosixPath(name).suffix.lower() if isinstance(name, str) else ""
    if suffix not in ACCEPTED:
        raise InputError(f"{name}: is no recording, bench file, model or map; those end in {', '.join(ACCEPTED)}")
    return folder.target(name, PurePosixPath(name).suffix, replace=False)


def _written(target: Path, write: Callable[[IO[bytes]], None]) -> None:
    """Writes a temporary file and links it to ``target``, which fails if there is one by now."""
    temporary = target.with_name(f".{target.name}.{os.getpid()}.{os.urandom(4).hex()}.part")
    try:
        with open(temporary, "xb") as file:
            write(file)
        os.link(temporary, target)
    except FileExistsError as error:
        raise Taken(f"{target.name}: exists already; rename one of them") from error
    except OSError as error:
        raise InputError(f"{target.name}: cannot be written ({error.strerror})") from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def _copied(name: str, stream: IO[bytes], file: IO[bytes], *, length: int) -> None:
    left = length
    while left:
        block = stream.read(min(_BLOCK, left))
        if not block:
            raise InputError(f"{name}: ended after {length - left} of {length} bytes; send it again")
        file.write(block)
        left -= len(block)


def _unpacked(folder: Folder, packed: Path) -> str:
    """The files of the rosbag2 folder in an archive, in a folder of the archive's name."""
    name = str(packed.with_suffix("").relative_to(folder.root))
    try:
        with zipfile.ZipFile(packed) as archive:
            chosen = _bag_members(packed.name, archive)
            if sum(member.file_size for member in chosen) > shutil.disk_usage(folder.root).free - SPARE:
                raise InputError(f"{packed.name}: does not fit on the disk when it is unpacked")
            for member in chosen:
                inside = f"{name}/{PurePosixPath(member.filename).name}"
                with archive.open(member) as stream:
                    _written(_place(folder, inside), partial(_copied, inside, stream, length=member.file_size))
    except InputError:
        shutil.rmtree(packed.with_suffix(""), ignore_errors=True)  # it was not there before
        raise
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        shutil.rmtree(packed.with_suffix(""), ignore_errors=True)
        raise InputError(f"{packed.name}: cannot be unpacked ({error}); pack it again") from error
    return name


def _bag_members(name: str, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """The archive's metadata.yaml and the storage files beside it."""
    members = [member for member in archive.infolist() if not member.is_dir()][: _MOST_MEMBERS + 1]
    places = [PurePosixPath(member.filename) for member in members]
    bags = [place.parent for place in places if place.name == "metadata.yaml"]
    if len(bags) != 1 or len(members) > _MOST_MEMBERS:
        raise InputError(f"{name}: holds {len(bags)} rosbag2 folders (metadata.yaml); pack one into each archive")
    wanted = (".yaml", *STORAGE)
    return [member for member, at in zip(members, places, strict=True) if at.parent == bags[0] and at.suffix in wanted]
