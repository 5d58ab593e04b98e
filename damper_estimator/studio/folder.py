"""The one folder that the studio reads from and writes to; nothing outside of it is reached from a page."""

import os
import re
import stat
from collections.abc import Callable
from pathlib import Path

from damper_estimator.errors import InputError

DEEPEST, MOST = 3, 500  # folders below the given one, entries that are listed of a kind
LARGEST_YAML = 1_000_000  # bytes
YAML = (".yaml", ".yml")
BENCH = (".csv", ".txt", ".tsv", ".dat", ".asc", ".log", ".mat", ".gz")
_MODEL = re.compile(r"^effects\s*:", re.MULTILINE)
_RIG = re.compile(r"^kind\s*:", re.MULTILINE)
_MAP = re.compile(r"^(dampers|filter|use)\s*:", re.MULTILINE)


class Taken(InputError):
    """There is a file of that name already."""


class Folder:
    """What lies in a folder, by names relative to it; final. Every name that a page sends goes through ``path``."""

    def __init__(self, root: str | Path) -> None:
        """Raises InputError where there is no such folder."""
        self.root = Path(root).resolve()
        if not self.root.is_dir():
            raise InputError(f"{root}: is no folder; name the one that holds your recordings")

    def path(self, name: object) -> Path:
        """The file or folder of a name; it need not exist.

        Raises:
            InputError: where the name leads out of the folder (absolute, by ``..`` or by a symbolic link), or what it
                names, or lies directly in it, is neither a file nor a folder (a device, a pipe, a socket).
        """
        given = _relative(name)
        if given is None:
            raise InputError(f"{name!r}: is not a name in the studio's folder {self.root}; choose one from the list")
        try:
            found = (self.root / given).resolve()
            leaves = not found.is_relative_to(self.root)
            inside = [found, *found.iterdir()] if not leaves and found.is_dir() else [found]
            leaves = not all(path.resolve().is_relative_to(self.root) for path in inside)
            odd = not leaves and not all(_ordinary(path) for path in inside)
        except (OSError, RuntimeError) as error:  # a name that is too long, links in a circle, no right to look
            raise InputError(f"{str(name)[:80]!r}: cannot be looked up; choose a name from the list") from error
        if leaves:
            raise InputError(f"{name}: leads out of the studio's folder {self.root}; start the studio on that folder")
        if odd:
            raise InputError(f"{name}: is neither a file nor a folder, or holds something else; choose another one")
        return found

    def existing(self, name: object, suffixes: tuple[str, ...] = ()) -> Path:
        """The same, for what must be there; with ``suffixes`` it must be a file that has one of them.

        Raises:
            InputError: also where it is not there, or a YAML file is larger than a model or map ever is.
        """
        found = self.path(name)
        if not found.exists():
            raise InputError(f"{name}: is no longer in {self.root}; choose another one")
        if suffixes and not (found.is_file() and found.suffix in suffixes):
            raise InputError(f"{name}: is no {' or '.join(suffixes)} file; choose one from the list")
        if found.suffix in YAML and found.stat().st_size > LARGEST_YAML:
            raise InputError(f"{name}: is larger than {LARGEST_YAML // 1_000_000} MB; that is no model and no map")
        return found

    def target(self, name: object, suffix: str, replace: bool) -> Path:
        """Where a file is to be written; its folder is made.

        Raises:
            InputError: for a name that leads out of the folder or has another suffix.
            Taken: where there is one and it was not agreed to ``replace`` it.
        """
        found = self.path(name)
        parts = found.relative_to(self.root).parts
        if found.suffix != suffix or any(part.startswith(".") for part in parts):
            raise InputError(f"{name}: give a name that ends in {suffix}")
        if found.is_dir():
            raise InputError(f"{name}: is a folder; give another name")
        if found.exists() and not replace:
            raise Taken(f"{name}: exists already; replace it, or give another name")
        try:
            found.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{name}: its folder cannot be made ({error.strerror}); give another name") from error
        return found

    def recordings(self) -> list[str]:
        """Names of ``.mcap`` and ``.db3`` files and of rosbag2 folders."""
        return self._listed(lambda path: path.suffix in (".mcap", ".db3") or (path / "metadata.yaml").is_file())

    def bench_files(self) -> list[str]:
        """Names of files that may be those of a bench or logger."""
        return self._listed(lambda path: path.suffix.lower() in BENCH)

    def models(self) -> list[str]:
        """Names of YAML files that list effects."""
        return self._listed(lambda path: _MODEL.search(_head(path)) is not None)

    def maps(self) -> list[str]:
        """Names of YAML files that map signals."""
        return self._listed(lambda path: _MAP.search(_head(path)) is not None and not _MODEL.search(_head(path)))

    def rigs(self) -> list[str]:
        """Names of YAML files that describe a rig."""
        return self._listed(lambda path: _RIG.search(_head(path)) is not None)

    def _listed(self, wanted: Callable[[Path], bool]) -> list[str]:
        names: list[str] = []
        for folder, below, files in os.walk(self.root):
            here = Path(folder)
            depth = len(here.relative_to(self.root).parts)
            if here != self.root and wanted(here):
                names.append(str(here.relative_to(self.root)))
                below.clear()
                continue
            below[:] = sorted(name for name in below if not name.startswith(".")) if depth < DEEPEST else []
            there = (str((here / file).relative_to(self.root)) for file in files if not file.startswith("."))
            names += [name for name in there if self._is_file(name) and wanted(self.root / name)]
        return sorted(name for name in names if not Path(name).name.startswith("."))[:MOST]

    def _is_file(self, name: str) -> bool:
        try:
            return self.path(name).is_file()
        except InputError:
            return False


def _relative(name: object) -> Path | None:
    """A name as a relative path; None where it is none."""
    if not isinstance(name, str) or not name or "\0" in name:
        return None
    given = Path(name)
    return None if given.is_absolute() or ".." in given.parts or not given.parts else given


def _ordinary(path: Path) -> bool:
    """Whether it is a file or a folder, or not there at all."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return True
    return stat.S_ISREG(mode) or stat.S_ISDIR(mode)


def _head(path: Path) -> str:
    """The text of a small YAML file; "" for everything else."""
    try:
        if path.suffix in YAML and path.is_file() and path.stat().st_size <= LARGEST_YAML:
            return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        pass
    return ""
