"""Sessions as files: what was opened and every step, in ``.damper_studio/NAME.json`` of the studio's folder.

A file is written whenever a step is made, undone or saved. It is data alone (JSON, with models and maps as YAML), so
that a file from someone else cannot do anything but be refused. A diagnosis is not in it: it is run again.
"""

import json
import re
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path

import yaml

from damper_estimator.diagnosis import Step
from damper_estimator.errors import InputError
from damper_estimator.files import json_text, write_text
from damper_estimator.model import parse_model
from damper_estimator.model.model_files import model_yaml
from damper_estimator.numbers import number
from damper_estimator.signals import parse_signal_map, signal_map_yaml
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.history import History, Version
from damper_estimator.studio.stage import Choice, Stage

PLACE, SUFFIX = ".damper_studio", ".json"
LARGEST = 20_000_000  # bytes
LISTED = 30  # newest sessions that are offered
_NAME = re.compile(r"[A-Za-z0-9_-]{8,40}")

Stamp = tuple[int, int, int] | None


@dataclass(frozen=True)
class SavedSession:
    """What a session's file says.

    Attributes:
        choice, models: what was opened.
        at: index of the step on view.
        steps: the records of the steps, checked when they are made into a history.
        owner: which browser tab wrote it.
        stamp: tells whether the file was written since by somebody else.
    """

    choice: Choice
    models: tuple[str, ...]
    at: int
    steps: tuple[Mapping[str, object], ...]
    owner: str
    stamp: Stamp

    @property
    def in_words(self) -> str:
        """What it is about, in a line."""
        last = self.steps[self.at] if 0 <= self.at < len(self.steps) else {}
        done = f"{self.at} step{'s' if self.at != 1 else ''}"
        error = last.get("rmse_unseen_n")
        found = f", {number(error)} N unseen" if isinstance(error, float) else ""
        named = [", ".join(self.choice.fit), self.choice.damper, self.models[0]]
        return f"{' · '.join(filter(None, named))}: {done}{found}"


class SessionFiles:
    """The sessions of a folder; final."""

    def __init__(self, folder: Folder) -> None:
        self._folder = folder

    def read(self, name: str) -> SavedSession:
        """A session's file.

        Raises:
            InputError: where there is none of that name, or it is damaged.
        """
        path = self._path(name)
        try:
            stamp = _stamp(path)
            if stamp is None:
                raise InputError(f"session {name}: is no longer in {self._folder.root}")
            if stamp[1] > LARGEST:
                raise InputError(f"session {name}: its file is larger than any session; it is not read")
            return _kept(json.loads(path.read_text(encoding="utf-8")), stamp)
        except OSError as error:
            raise InputError(f"session {name}: cannot be read ({error.strerror})") from error
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            raise InputError(f"session {name}: its file is damaged; open the recordings again") from error

    def write(self, name: str, stamp: Stamp, record: Mapping[str, object]) -> tuple[str, Stamp]:
        """Writes a session; under a new name where its file is not the one that this session wrote or read last.

        Returns:
            the name, and the stamp to give the next time.

        Raises:
            InputError: where it cannot be written.
        """
        if not name or _stamp(self._path(name)) != stamp:
            name = new_name()
        path = self._path(name)
        try:
            path.parent.mkdir(exist_ok=True)
        except OSError as error:
            raise InputError(f"{path.parent}: cannot be made ({error.strerror})") from error
        write_text(path, json_text(record))
        return name, _stamp(path)

    def listed(self) -> list[tuple[str, str, str]]:
        """Name, content in words and time of the newest sessions."""
        place = self._folder.path(PLACE)
        if not place.is_dir():
            return []
        found = sorted(place.glob(f"*{SUFFIX}"), key=lambda path: -(_stamp(path) or (0,))[0])
        return [entry for path in found[:LISTED] if (entry := self._entry(path.stem)) is not None]

    def _entry(self, name: str) -> tuple[str, str, str] | None:
        try:
            kept = self.read(name)
        except InputError:
            return None
        when = datetime.fromtimestamp(kept.stamp[0] * 1e-9).astimezone()
        return name, kept.in_words, f"{when:%Y-%m-%d %H:%M}"

    def _path(self, name: object) -> Path:
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            raise InputError(f"{str(name)[:60]!r}: is not the name of a session")
        return self._folder.path(f"{PLACE}/{name}{SUFFIX}")


def new_name() -> str:
    """A name that no other session has and nobody guesses."""
    return secrets.token_urlsafe(9)


def session_record(stage: Stage, models: Sequence[str], at: int, steps: Sequence[Mapping], owner: str) -> dict:
    """What a session's file says; ``steps`` as `step_record` gives them, with ``saved``, the name of the model file."""
    choice = asdict(stage.choice) | {"damper": stage.damper}
    return {"studio": 1, "choice": choice, "models": list(models), "at": at, "owner": owner, "steps": list(steps)}


def step_record(stage: Stage, version: Version) -> dict[str, object]:
    """A step without ``saved``; the map only where the step's differs from the one that was opened."""
    step = version.step
    changed = version.signals != stage.signals
    return {
        "action": step.action,
        "effect": step.effect,
        "phenomenon": step.phenomenon,
        "rmse_fit_n": step.rmse_fit_n,
        "rmse_unseen_n": step.rmse_unseen_n,
        "model": model_yaml(step.model),
        "map": signal_map_yaml(stage.signal_map.with_entry(stage.damper, version.signals)) if changed else None,
    }


def _kept(content: Mapping, stamp: Stamp) -> SavedSession:
    given = content["choice"]
    window = [None if given[name] is None else float(given[name]) for name in ("start", "stop")]
    choice = Choice(
        tuple(map(str, given["fit"])), tuple(map(str, given["unseen"])), str(given["damper"]), str(given["signals"]),
        *window, tuple((int(i), float(a), float(b)) for i, a, b in given.get("left_out", ())),
    )  # fmt: skip
    models, steps = tuple(map(str, content["models"])), tuple(dict(step) for step in content["steps"])
    if not (choice.fit and models and steps):
        raise ValueError(content)
    return SavedSession(choice, models, int(content["at"]), steps, str(content["owner"]), stamp)


def history_of(kept: SavedSession, stage: Stage, name: str) -> tuple[History, list[str]]:
    """The steps of a session's file, and which file each was saved to.

    Raises:
        InputError: where a step is no model or no map.
    """
    where, versions = f"session {name}", []
    try:
        for step in kept.steps:
            model = parse_model(yaml.safe_load(str(step["model"])), where)
            signals = stage.signals
            if step["map"] is not None:
                signals = parse_signal_map(yaml.safe_load(str(step["map"])), where).dampers[stage.damper]
            errors = [float("nan") if step[n] is None else float(step[n]) for n in ("rmse_fit_n", "rmse_unseen_n")]
            action, effect, phenomenon = (None if step[n] is None else str(step[n]) for n in _WORDS)
            versions.append(Version(Step(str(action), effect, phenomenon, model, *errors, None, ""), signals))
        files = [str(step["saved"]) for step in kept.steps]
    except (ValueError, TypeError, KeyError, yaml.YAMLError) as error:
        raise InputError(f"{where}: its file is damaged; open the recordings again") from error
    return History(tuple(versions), min(max(kept.at, 0), len(versions) - 1)), files


_WORDS = ("action", "effect", "phenomenon")


def _stamp(path: Path) -> Stamp:
    """Tells one content of a file from the next; None where there is no file. Each writing makes a file of its own."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino
