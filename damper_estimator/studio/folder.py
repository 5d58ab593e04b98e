"""The one folder that the studio reads from and writes to; nothing outside of it is reached from a page."""

import os
import re
from pathlib import Path

from damper_estimator.errors import InputError

DEEPEST, MOST = 3, 500  # folders below the given one, entries that are listed of a kind
LARGEST_YAML = 1_000_000  # bytes
_MODEL = re.compile(r"^effects\s*:", re.MULTILINE)
_MAP = re.compile(r"^(dampers|filter|use)\s*:", re.MULTILINE)


class Taken(InputError):
    """There is a file of that name already."""


class Folder:
    """What lies in a folder, by names relative to it; final."""

    def __init__(self, root: str | Path) -> None:
        """Raises InputError where there is no such folder."""
        self.root = Path(root).resolve()
        if not self.root.is_dir():
            raise InputError(f"{root}: is no folder; name the one that holds your recordings")

    def path(self, name: str) -> Path:
        """The file or folder of a name.

        Raises:
            InputError: where the name leads out of the folder: absolute, by ``..`` or by a symbolic link.
        """
        given = Path(name)
        if not name or "\0" in name or given.is_absolute() or ".." in given.parts:
            raise InputError(f"{name!r}: is not a name in the studio's folder {self.root}; choose one from the list")
        found = (self.root / given).resolve()
        inside = [found, *found.iterdir()] if found.is_dir() else [found]
        if not all(path.resolve().is_relative_to(self.root) for path in inside):
            raise InputError(f"{name}: leads out of the studio's folder {self.root}; start the studio on that folder")
        return found

    def existing(self, name: str) -> Path:
        """The same, for what must be there.

        Raises:
            InputError: also where it is not there, or a YAML file is larger than a model or map ever is.
        """
        found = self.path(name)
        if not found.exists():
            raise InputError(f"{name}: is no longer in {self.root}; choose another one")
        if found.suffix in (".yaml", ".yml") and found.stat().st_size > LARGEST_YAML:
            raise InputError(f"{name}: is larger than {LARGEST_YAML // 1_000_000} MB; that is no model and no map")
        return found

    def target(self, name: str, suffix: str, replace: bool) -> Path:
        """Where a file is to be written; its folder is made.

        Raises:
            InputError: for a name that leads out of the folder or has another suffix.
            Taken: where there is one and it was not agreed to ``replace`` it.
        """
        found = self.path(name)
        if found.suffix != suffix or found.name.startswith("."):
            raise InputError(f"{name}: give a name that ends in {suffix}")
        if found.is_dir():
            raise InputError(f"{name}: is a folder; give another name")
        if found.exists() and not replace:
            raise Taken(f"{name}: exists already; replace it, or give another name")
        found.parent.mkdir(parents=True, exist_ok=True)
        return found

    def recordings(self) -> list[str]:
        """Names of ``.mcap`` and ``.db3`` files and of rosbag2 folders."""
        return self._listed(lambda path: path.suffix in (".mcap", ".db3") or (path / "metadata.yaml").is_file())

    def models(self) -> list[str]:
        """Names of YAML files that list effects."""
        return self._listed(lambda path: _MODEL.search(_head(path)) is not None)

    def maps(self) -> list[str]:
        """Names of YAML files that map signals."""
        return self._listed(lambda path: _MAP.search(_head(path)) is not None and not _MODEL.search(_head(path)))

    def _listed(self, wanted) -> list[str]:
        names: list[str] = []
        for folder, below, files in os.walk(self.root):
            here = Path(folder)
            depth = len(here.relative_to(self.root).parts)
            if here != self.root and wanted(here):
                names.append(str(here.relative_to(self.root)))
                below.clear()
                continue
            below[:] = sorted(own for own in below if not own.startswith(".")) if depth < DEEPEST else []
            names += [str((here / own).relative_to(self.root)) for own in files if wanted(here / own)]
        return sorted(name for name in names if not Path(name).name.startswith("."))[:MOST]


def _head(path: Path) -> str:
    """The text of a small YAML file; "" for everything else."""
    try:
        if path.suffix in (".yaml", ".yml") and path.is_file() and path.stat().st_size <= LARGEST_YAML:
            return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        pass
    return ""
