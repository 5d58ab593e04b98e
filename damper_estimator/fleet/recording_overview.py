"""Overview of a recording before its tasks: dampers, time, temperatures, checksum."""

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
class RecordingOverview:
    """The facts about a recording that its tasks need.

    Attributes:
        state: checksum of the files and the signal map; the overview is valid while it is unchanged.
        checksum: of the contents.
        begin_ns: stamp of the first displacement, ns; None if there is none.
        seconds: from the first to the last displacement.
        temperature_c: mean over the recording by damper; None if not measured.
        reason: why the recording cannot be used; "" if it can.
        notes: warnings of the reader, such as a truncated file.
    """

    state: str
    checksum: str
    begin_ns: int | None
    seconds: float | None
    temperature_c: dict[str, float | None]
    reason: str = ""
    notes: str = ""


def state_of(recording: str, signals: str) -> str:
    """Checksum that changes with the files of a recording, its signal map or the package version."""
    return digest([signature(recording), map_checksum(signals), __version__])


def map_checksum(signals: str) -> str:
    """Checksum of a signal map's file; "" for the default topics, or if it cannot be read."""
    if not signals or not Path(signals).is_file():
        return ""
    return digest(Path(signals).read_text(encoding="utf-8", errors="replace"))


def kept_overview(folder: Path, state: str) -> RecordingOverview | None:
    """The stored overview if it is still valid."""
    try:
        overview = RecordingOverview(**json.loads((folder / _FILE).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None
    return overview if overview.state == state else None


def read_overview(recording: str, signals: str, folder: str) -> RecordingOverview:
    """Reads the overview of a recording and stores it.

    Raises:
        InputError: if the result cannot be written.
    """
    state = state_of(recording, signals)
    warnings = io.StringIO()
    try:
        with redirect_stderr(warnings):
            contents = _contents(recording, load_signal_map(signals or None))
        overview = RecordingOverview(state, checksum(recording), *contents, notes=" ".join(warnings.getvalue().split()))
    except InputError as error:
        overview = RecordingOverview(state, state, None, None, {}, str(error))
    except OSError as error:
        overview = RecordingOverview(
            state, state, None, None, {}, f"{recording}: cannot be read ({error.strerror}); check the path"
        )
    Path(folder).mkdir(parents=True, exist_ok=True)
    write_text(Path(folder) / _FILE, json.dumps(asdict(overview)))
    return overview


def _contents(recording: str, signal_map: SignalMap) -> tuple[int | None, float | None, dict[str, float | None]]:
    with open_bag(recording) as bag:
        dampers = signals_for(bag, signal_map).dampers
        displacements = {name: signals.displacement for name, signals in dampers.items()}
        temperatures = {
            name: signals.temperature for name, signals in dampers.items() if find_topic(bag, signals.temperature.topic)
        }
        begin, seconds, mean = None, None, {}
        # A damper with unreadable channels is reported by its own task.
        with suppress(InputError):
            stamps = np.concatenate([data.stamp for data in _ends(bag, displacements).values()])
            begin, seconds = int(stamps.min()), int(np.ptp(stamps)) / 1e9
        with suppress(InputError):
            mean = {name: _mean(data.value) for name, data in read_channels(bag, temperatures).items()}
    return begin, seconds, {name: mean.get(name) for name in dampers}


def _ends(bag: Bag, channels: Mapping[str, Channel]) -> dict[str, ChannelData]:
    """The channels at both ends of the bag, which saves reading all of it; all their samples if one is missing there.

    Raises:
        InputError: if there are none at all.
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
