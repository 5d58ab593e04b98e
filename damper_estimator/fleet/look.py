"""A first look into a recording: which dampers it has, when it was made, how warm they were, its checksum."""

import io
import json
from collections.abc import Mapping
from contextlib import redirect_stderr, suppress
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.fleet.task import checksum, digest, signature
from damper_estimator.recordings import Bag, open_bag
from damper_estimator.signals import Channel, SignalMap, load_signal_map
from damper_estimator.signals.channels import ChannelData, find_topic, read_channels, signals_for

_FILE = "recording.json"


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
        moved = {name: own.displacement for name, own in dampers.items()}
        warm = {name: own.temperature for name, own in dampers.items() if find_topic(bag, own.temperature.topic)}
        begin, seconds, mean = None, None, {}
        # A damper whose channels cannot be read is told of by its own task.
        with suppress(InputError):
            stamps = np.concatenate([own.stamp for own in _ends(bag, moved).values()])
            begin, seconds = int(stamps.min()), int(np.ptp(stamps)) / 1e9
        with suppress(InputError):
            mean = {name: _mean(own.value) for name, own in read_channels(bag, warm).items()}
    return begin, seconds, {name: mean.get(name) for name in dampers}


def _ends(bag: Bag, channels: Mapping[str, Channel]) -> dict[str, ChannelData]:
    """The channels at both ends of the bag, so that a look does not read it all; where one is not there, all of them.

    Raises:
        InputError: where none is there at all.
    """
    with suppress(InputError):
        data = read_channels(bag, channels, ends=True)
        if len(data) == len(channels):
            return data
    data = read_channels(bag, channels)
    if not data:
        raise InputError(f"{bag.path}: has no displacement")
    return data


def _mean(values: np.ndarray) -> float | None:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else None
