"""The folder and the library at a glance: one card per recording and model, with a small picture of F-v."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, library_models, load_model
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X
from damper_estimator.studio.captured_warnings import captured_warnings
from damper_estimator.studio.folder import YAML, Folder
from damper_estimator.studio.thumbnail import picture
from damper_estimator.workflows import read

LARGEST = 300_000_000  # bytes of a recording that is looked into
_SECONDS = 30.0  # of it
_USUAL = {COMMAND: 0.5, TEMPERATURE: 40.0, PRESSURE: 2e6}
_NEEDS = {COMMAND: "command", TEMPERATURE: "temperature", PRESSURE: "pressure"}


@dataclass(frozen=True)
class Card:
    """One card.

    Attributes:
        kind: recordings or models.
        lines: what is said of it.
        bad: what is suspicious, "" for nothing.
        picture: F-v as an image's address; "" for none.
    """

    kind: str
    name: str
    lines: tuple[str, ...] = ()
    bad: str = ""
    picture: str = ""

    def fits(self, words: str) -> bool:
        """Whether every word of a search is in it."""
        text = " ".join((self.name, *self.lines, self.bad)).lower()
        return all(word in text for word in words.lower().split())


class Cards:
    """Makes cards in a thread of its own, again where a file has changed; final."""

    def __init__(self, folder: Folder) -> None:
        self._folder, self._lock = folder, threading.Lock()
        self._made: dict[tuple[str, str], tuple[object, Card]] = {}
        self._working = False

    def now(self) -> list[Card]:
        """The cards as far as they are made; those that are missing come later."""
        wanted = [("recordings", name) for name in self._folder.recordings()]
        wanted += [("models", name) for name in (*self._folder.models(), *library_models())]
        with self._lock:
            found = [self._made.get(key, (None, Card(*key, ("looking into it ...",)))) for key in wanted]
            missing = [key for key, (stamp, _) in zip(wanted, found, strict=True) if stamp != self._stamp(*key)]
            if missing and not self._working:
                self._working = True
                threading.Thread(target=self._make, args=(missing,), daemon=True).start()
        return [card for _, card in found]

    def _make(self, wanted: Sequence[tuple[str, str]]) -> None:
        makers: dict[str, Callable[[str], Card]] = {"recordings": self._recording, "models": self._model}
        try:
            for kind, name in wanted:
                stamp = self._stamp(kind, name)
                try:
                    card = makers[kind](name)
                except InputError as error:
                    card = Card(kind, name, (), str(error))
                with self._lock:
                    self._made[kind, name] = stamp, card
        finally:
            self._working = False

    def _stamp(self, kind: str, name: str) -> object:
        try:
            path = library_models().get(name) or self._folder.path(name)
            found = path.stat()
        except (InputError, OSError):
            return "gone"
        return found.st_mtime_ns, found.st_size

    def _recording(self, name: str) -> Card:
        path = self._folder.existing(name)
        size = sum(file.stat().st_size for file in ([path] if path.is_file() else path.iterdir()))
        if size > LARGEST:
            return Card("recordings", name, (f"{size / 1e6:.0f} MB: too large for a glance; open it",))
        with captured_warnings() as warned:
            found = read(path, stop=_SECONDS)
        dampers = tuple(found.dampers)
        lines = [f"{len(dampers)} damper{'s' if len(dampers) != 1 else ''}: {', '.join(dampers)}"]
        first = found.measurements[dampers[0]][0]
        kinematics, force = first.kinematics, first.force
        seconds = float(kinematics.time[-1] - kinematics.time[0])
        more = f"first {_SECONDS:g} s of it" if seconds > 0.98 * _SECONDS else f"{seconds:.3g} s"
        lines.append(f"{more}, {len(kinematics) / max(seconds, 1e-9):.4g} Hz, {size / 1e6:.3g} MB")
        rows = {"command": COMMAND, "temperature": TEMPERATURE, "pressure": PRESSURE}
        there = [key for key, row in rows.items() if np.isfinite(kinematics.block[row]).any()]
        lines.append("channels: " + ", ".join(["displacement", *(["force"] if force is not None else []), *there]))
        bad = "no measured force" if force is None else " ".join(warned[:1])
        drawn = "" if force is None else picture(kinematics.velocity, np.asarray(force))
        return Card("recordings", name, tuple(lines), bad, drawn)

    def _model(self, name: str) -> Card:
        library = library_models()
        path: Path = library[name] if name in library else self._folder.existing(name, YAML)
        model = load_model(path)
        free = sum(not slot.fixed for slot in model.slots)
        effects = ", ".join(dict.fromkeys(entry.effect.name for entry in model.effects))
        velocity, force, needs = characteristic(model)
        fitted = "identified" if model.fit else "never identified"
        lines = (
            effects,
            f"{len(model.slots)} parameters ({free} free), {fitted}",
            f"needs {', '.join(['displacement', *needs])}",
            f"source: {model.source}" if model.source else "",
        )
        return Card("models", name, tuple(filter(None, lines)), "", picture(velocity, force))


def characteristic(model: DamperModel) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Velocity and force of one cycle of 25 mm at 2 Hz, and which slow channels the force depends on."""
    time = np.arange(0.0, 1.0, 1e-3)
    block = np.full((ROWS, time.size), np.nan)
    omega = 4.0 * np.pi
    block[T], block[DT] = time, 1e-3
    block[DT, 0] = 0.0
    block[X], block[V] = 0.025 * np.sin(omega * time), 0.025 * omega * np.cos(omega * time)
    block[A] = -(omega**2) * block[X]
    for row, value in _USUAL.items():
        block[row] = value
    force, needs = model.force(block), []
    for row, name in _NEEDS.items():
        other = block.copy()
        other[row] *= 1.5
        if not np.allclose(model.force(other), force, rtol=1e-9, atol=1e-9, equal_nan=True):
            needs.append(name)
    half = slice(time.size // 2, None)
    return block[V][half], force[half], needs
