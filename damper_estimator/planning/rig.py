"""Test rigs: what they can do to a damper, what can be changed on them, and what they measure; from a file."""

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError, did_you_mean
from damper_estimator.files import read_yaml
from damper_estimator.share import share_path

LIBRARY = "config/rigs"
KINDS = ("played", "crank", "manoeuvres")
MEASURED = ("displacement", "force", "temperature", "current", "pressure", "acceleration")
Range = tuple[float, float]


@dataclass(frozen=True)
class Manoeuvre:
    """What a driver is asked to do, and the damper's motion that is expected of it.

    Attributes:
        say: in words.
        band: Hz, lowest and highest frequency.
        speed: m/s rms.
        seconds: length.
    """

    say: str
    band: Range
    speed: float
    seconds: float


@dataclass(frozen=True)
class Rig:
    """A test rig; SI units, displacement positive in extension.

    Attributes:
        name, source: from the file.
        kind: ``played`` plays a drive file, ``crank`` drives sines of one amplitude, ``manoeuvres`` is a vehicle.
        rate: Hz, of the drive file.
        displacement: m, what the rig reaches, about the damper's zero.
        speed, acceleration, force: largest, m/s, m/s^2, N.
        frequency: Hz.
        mean_positions: whether the mean position can be moved.
        measures: channels of ``MEASURED``.
        amplitude: m, of a crank; else 0.
        temperature, current: deg C and A that can be set; empty where they cannot be changed.
        travel: m, of the damper between its stops; None where unknown.
        manoeuvres: of a vehicle.
    """

    name: str
    source: str
    kind: str
    rate: float
    displacement: Range
    speed: float
    acceleration: float
    force: float
    frequency: Range
    mean_positions: bool = False
    measures: tuple[str, ...] = ("displacement", "force")
    amplitude: float = 0.0
    temperature: tuple[float, ...] = ()
    current: tuple[float, ...] = ()
    travel: Range | None = None
    manoeuvres: tuple[Manoeuvre, ...] = ()


def library_rigs() -> list[str]:
    """Names of the rigs that come with the package."""
    return sorted(path.stem for path in share_path(LIBRARY).glob("*.yaml"))


def load_rig(name: str | Path) -> Rig:
    """A rig of the library by name, or from a YAML file.

    Raises:
        InputError: one line that names the file and the entry.
    """
    path = Path(name)
    if path.suffix not in (".yaml", ".yml"):
        known = library_rigs()
        if str(name) not in known:
            raise InputError(
                f"rig {name}: is no YAML file, and the library has {', '.join(known)}{did_you_mean(str(name), known)}"
            )
        path = share_path(f"{LIBRARY}/{name}.yaml")
    return parse_rig(read_yaml(path), str(path))


def parse_rig(content: object, where: str) -> Rig:
    """A rig from the content of its file; ``where`` names it in errors.

    Raises:
        InputError: one line.
    """
    if not isinstance(content, Mapping):
        raise InputError(f"{where}: is no rig; it needs entries such as name, kind, rate, displacement")
    known = {field.name: field for field in fields(Rig)}
    for key in content:
        if key not in known:
            raise InputError(f"{where}: unknown entry {key}{did_you_mean(str(key), known)}")
    missing = [name for name, field in known.items() if field.default is MISSING and name not in content]
    if missing:
        raise InputError(f"{where}: has no {', '.join(missing)}; every rig needs them")
    rig = Rig(**{key: _entry(key, value, where) for key, value in content.items()})
    _check(rig, where)
    return rig


def _entry(key: str, value: object, where: str) -> object:
    if key in ("name", "source", "kind"):
        return str(value)
    if key == "mean_positions":
        if not isinstance(value, bool):
            raise InputError(f"{where}: mean_positions is {value!r}; write true or false")
        return value
    if key == "measures":
        return tuple(str(item) for item in value) if isinstance(value, list) else (str(value),)
    if key == "manoeuvres":
        return tuple(_manoeuvre(item, where) for item in (value if isinstance(value, list) else [value]))
    if key in ("displacement", "frequency", "travel"):
        return _range(key, value, where)
    if key in ("temperature", "current"):
        return tuple(_number(key, item, where) for item in (value if isinstance(value, list) else [value]))
    return _number(key, value, where)


def _manoeuvre(value: object, where: str) -> Manoeuvre:
    names = {field.name for field in fields(Manoeuvre)}
    if not isinstance(value, Mapping) or set(value) != names:
        raise InputError(f"{where}: a manoeuvre needs exactly {', '.join(sorted(names))}")
    band = _range("band", value["band"], where)
    speed, seconds = (_number(name, value[name], where) for name in ("speed", "seconds"))
    if not (0.0 < band[0] and speed > 0.0 and 4.0 <= seconds <= 600.0):
        raise InputError(f"{where}: manoeuvre {value['say']!r}: band and speed are positive, seconds from 4 to 600")
    return Manoeuvre(str(value["say"]), band, speed, seconds)


def _number(key: str, value: object, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
        raise InputError(f"{where}: {key} is {value!r}; give a number")
    return float(value)


def _range(key: str, value: object, where: str) -> Range:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        raise InputError(f"{where}: {key} is {value!r}; give [lowest, highest]")
    low, high = (_number(key, item, where) for item in value)
    if low >= high:
        raise InputError(f"{where}: {key} goes from {low:g} to {high:g}; the lowest comes first")
    return low, high


def _check(rig: Rig, where: str) -> None:
    if rig.kind not in KINDS:
        raise InputError(f"{where}: kind {rig.kind} is none of {', '.join(KINDS)}")
    for name in ("rate", "speed", "acceleration", "force"):
        if getattr(rig, name) <= 0.0:
            raise InputError(f"{where}: {name} is {getattr(rig, name):g}; it must be positive")
    if rig.frequency[0] <= 0.0:
        raise InputError(f"{where}: frequency begins at {rig.frequency[0]:g} Hz; it must be positive")
    if rig.rate < 4.0 * rig.frequency[1]:
        raise InputError(
            f"{where}: rate {rig.rate:g} Hz is too low for {rig.frequency[1]:g} Hz; give at least four samples per "
            "period"
        )
    if rig.kind == "crank" and not rig.amplitude > 0.0:
        raise InputError(f"{where}: a crank needs its amplitude in m")
    if rig.kind == "manoeuvres" and not rig.manoeuvres:
        raise InputError(f"{where}: a vehicle needs manoeuvres")
    unknown = [name for name in rig.measures if name not in MEASURED]
    if unknown:
        raise InputError(f"{where}: measures {', '.join(unknown)}; there are {', '.join(MEASURED)}")
    if not {"displacement", "force"} <= set(rig.measures):
        raise InputError(f"{where}: must measure displacement and force; without them no test tells anything")
