"""A first look into a recording: which dampers it has, when it was made, how warm they were, its checksum."""

import io
import json
from contextlib import redirect_stderr, suppress
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.fleet.task import checksum, digest, signature
from damper_estimator.recordings import open_bag
from damper_estimator.signals import SignalMap, load_signal_map
from damper_estimator.signals.channels import read_channels, signals_for

_FILE = "recording.json"
_ROLES = ("displacement", "temperature")


@dataclass(frozen=True)
class Look:
    """What a recording holds, as far as its tasks need it.

    Attributes:
        state: of the files and the signal map; while it stays, the look holds.
        checksum: of the contents.
        begin_ns: stamp of the first displacement, ns; None without.
        seconds: from there to the last.
        temperature_c: by damper, mean over the recording; None where it was not measured.
        reason: why the recording cannot be used, "" where it can.
        notes: what the reader said of it, such as that it is cut off.
    """

    state: str
    checksum: str
    begin_ns: int | None
    seconds: float | None
    temperature_c: dict[str, float | None]
    reason: str = ""
    notes: str = ""


def state_of(recording: str, signals: str) -> str:
    """Changes where the files of a recording, its signal map or the package change."""
    return digest([signature(recording), map_checksum(signals), __version__])


def map_checksum(signals: str) -> str:
    """Of a signal map's file; "" for the default topics and where it cannot be read."""
    if not signals or not Path(signals).is_file():
        return ""
    return digest(Path(signals).read_text(encoding="utf-8", errors="replace"))


def kept_look(folder: Path, state: str) -> Look | None:
    """The look that was taken before, where it still holds."""
    try:
        look = Look(**json.loads((folder / _FILE).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None
    return look if look.state == state else None


def take_look(recording: str, signals: str, folder: str) -> Look:
    """Looks into a recording and keeps what was seen.

    Raises:
        InputError: where the result cannot be written.
    """
    state = state_of(recording, signals)
    said = io.StringIO()
    try:
        with redirect_stderr(said):
            seen = _contents(recording, load_signal_map(signals or None))
        look = Look(state, checksum(recording), *seen, notes=" ".join(said.getvalue().split()))
    except InputError as error:
        look = Look(state, state, None, None, {}, str(error))
    except OSError as error:
        look = Look(state, state, None, None, {}, f"{recording}: cannot be read ({error.strerror}); check the path")
    Path(folder).mkdir(parents=True, exist_ok=True)
    write_text(Path(folder) / _FILE, json.dumps(asdict(look)))
    return look


def _contents(recording: str, signal_map: SignalMap) -> tuple[int | None, float | None, dict[str, float | None]]:
    with open_bag(recording) as bag:
        dampers = signals_for(bag, signal_map).dampers
        wanted = {f"{role} of {name}": getattr(own, role) for name, own in dampers.items() for role in _ROLES}
        # A damper whose channels cannot be read is told of by its own task.
        with suppress(InputError):
            data = read_channels(bag, wanted)
            stamps = [data[key].stamp for key in data if key.startswith("displacement of ")]
            begin = min((int(own.min()) for own in stamps), default=None)
            seconds = None if begin is None else (max(int(own.max()) for own in stamps) - begin) / 1e9
            warm = {name: data.get(f"temperature of {name}") for name in dampers}
            return begin, seconds, {name: None if own is None else _mean(own.value) for name, own in warm.items()}
    return None, None, dict.fromkeys(dampers)


def _mean(values: np.ndarray) -> float | None:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else None
