"""The signal map: which topic and field is which quantity of which damper, and its conversion to SI units."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from damper_estimator import files
from damper_estimator.errors import InputError
from damper_estimator.signals.element_path import named_element
from damper_estimator.signals.fusion import Fusion
from damper_estimator.signals.sensor_table import looked_up

DEFAULT_CUTOFF = 60.0  # Hz
DEFAULT_BAND = 30.0  # Hz
_UNITS = {"displacement": "m", "force": "N", "temperature": "deg C", "pressure": "Pa", "acceleration": "m/s^2"}
ROLES = ("displacement", "force", "command", "temperature", "pressure", "acceleration")


@dataclass(frozen=True)
class Channel:
    """One quantity: value = scale * raw + offset, or by a table; true(t) = value(t + skew).

    Attributes:
        topic, field: of the messages; ``field`` is a path of names and indices.
        scale, offset: raw to SI.
        skew: s, positive if the channel is late.
        table: raw values and values, instead of scale (motion ratio); None without. What is beyond it by more than 2 %
            of its range is no value.
        unit: of the command, for people; the others have the SI unit of their role.
        limits: raw, lowest and highest value: of the command the range of its driver (None: those of the model's fit),
            of temperature and pressure the range of the sensor (None: ordinary bounds).
        max_age: s, of command, temperature and pressure: age of a value above which the channel counts as silent;
            None: the role's ordinary age.
        given: whether a map names it, so that its absence is an error.
    """

    topic: str
    field: str
    scale: float = 1.0
    offset: float = 0.0
    skew: float = 0.0
    table: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    unit: str = ""
    limits: tuple[float, float] | None = None
    max_age: float | None = None
    given: bool = False

    def value(self, raw: np.ndarray) -> np.ndarray:
        """SI values of raw ones, any shape; the same code live and offline. NaN beyond a table: what a sensor gives
        there has no meaning.
        """
        return self.scale * raw + self.offset if self.table is None else looked_up(raw, self.table)

    @property
    def value_limits(self) -> tuple[float, float] | None:
        """The limits as SI values, in order."""
        if self.limits is None:
            return None
        ends = self.limits if self.table is None else np.clip(self.limits, self.table[0][0], self.table[0][-1])
        low, high = sorted(float(self.value(limit)) for limit in ends)
        return low, high

    def raw(self, value: float) -> float:
        """The raw number of an SI value; beyond a table its last one."""
        if self.table is None:
            return (value - self.offset) / self.scale
        raw, values = self.table if self.table[1][0] <= self.table[1][-1] else (column[::-1] for column in self.table)
        return float(np.interp(value, values, raw))


@dataclass(frozen=True)
class DamperSignals:
    """The channels of one damper; the force's spring rate (N/m) and preload (N) are subtracted to get the damper's
    force.
    """

    displacement: Channel
    force: Channel
    command: Channel
    temperature: Channel
    pressure: Channel
    acceleration: Channel
    spring_rate: float = 0.0
    preload: float = 0.0

    def channels(self) -> dict[str, Channel]:
        """Channel by role."""
        return {role: getattr(self, role) for role in ROLES}

    def with_channel(self, role: str, channel: Channel) -> "DamperSignals":
        """The same with another channel in a role."""
        given: dict[str, Any] = {role: channel}
        return replace(self, **given)


@dataclass(frozen=True)
class SignalMap:
    """The meaning of a recording's channels.

    Attributes:
        cutoff: Hz of the filter before the model; 0 is the unfiltered mode.
        band: Hz of the zero-phase low-pass of the comparison; 0 for none.
        dampers: signals by damper; empty: those named in the displacement messages, on the default topics.
        fusion: of displacement and acceleration, live and in replay; None: displacement alone.
        windows: (from, to) in s since the start, the usable parts of the recording; empty: all of it.
        where: the file, for errors.
    """

    cutoff: float = DEFAULT_CUTOFF
    band: float = DEFAULT_BAND
    dampers: Mapping[str, DamperSignals] = field(default_factory=dict)
    windows: tuple[tuple[float, float], ...] = ()
    where: str = "default signal map"
    fusion: Fusion | None = None

    @property
    def gauge_cutoff(self) -> float:
        """Hz, of the filter that delays the measured force like the estimate."""
        return self.cutoff if self.fusion is None else 0.0

    def with_dampers(self, names: list[str]) -> "SignalMap":
        """The map with default signals for the named dampers, if it names none."""
        return self if self.dampers else replace(self, dampers={name: default_signals(name) for name in names})

    def with_entry(self, damper: str, signals: DamperSignals) -> "SignalMap":
        """The map with one damper's entry replaced; a changed force counts as named."""
        changed = signals != self.dampers.get(damper)
        entry = replace(signals, force=replace(signals.force, given=True)) if changed else signals
        return replace(self, dampers={**self.dampers, damper: entry})


def default_signals(damper: str) -> DamperSignals:
    """The default topics for one damper."""
    namespace = f"suspension/{damper}"
    return DamperSignals(
        displacement=Channel("suspension/displacement", named_element("position", damper)),
        force=Channel("suspension/force", named_element("effort", damper)),
        command=Channel(f"{namespace}/current", "data", unit="A"),
        temperature=Channel(f"{namespace}/temperature", "temperature"),
        pressure=Channel(f"{namespace}/pressure", "fluid_pressure"),
        acceleration=Channel(f"{namespace}/acceleration", "accel.linear.z"),
    )


def load_signal_map(path: str | Path | None) -> SignalMap:
    """Reads a signal map; None stands for the default one.

    Raises:
        InputError: one line with the file and every unknown key or wrong value.
    """
    if path is None:
        return SignalMap()
    return parse_signal_map(files.read_yaml(path), str(path))


def parse_signal_map(content: object, where: str) -> SignalMap:
    """A signal map from its file's content.

    Raises:
        InputError: one line with the file and every unknown key or wrong value.
    """
    faults: list[str] = []
    top = _mapping(content if content is not None else {}, "the file", ("filter", "dampers", "use"), faults)
    chosen = _mapping(top.get("filter", {}), "filter", ("cutoff", "band", "fusion"), faults)
    dampers = {
        str(name): _damper(str(name), entry, faults)
        for name, entry in _mapping(top.get("dampers") or {}, "dampers", None, faults).items()
    }
    windows = top.get("use") or []
    if not isinstance(windows, list):
        faults.append("use must be a list of {from, to}")
        windows = []
    signal_map = SignalMap(
        cutoff=_frequency(chosen, "cutoff", DEFAULT_CUTOFF, faults),
        band=_frequency(chosen, "band", DEFAULT_BAND, faults),
        dampers=dampers,
        windows=tuple(_window(entry, faults) for entry in windows),
        where=where,
        fusion=_fusion(chosen["fusion"], faults) if "fusion" in chosen else None,
    )
    if faults:
        raise InputError(f"{where}: {'; '.join(faults)}")
    return signal_map


def _mapping(value: object, what: str, allowed: tuple[str, ...] | None, faults: list[str]) -> dict:
    if not isinstance(value, dict):
        faults.append(f"{what} must be a mapping, got {value!r}")
        return {}
    if allowed is not None:
        faults += [
            f"unknown key {key!r} in {what} (allowed: {', '.join(allowed)})" for key in value if key not in allowed
        ]
    return value


def _number(value: object, what: str, faults: list[str]) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value):
        return float(value)
    faults.append(f"{what} = {value!r} is not a number")
    return 0.0


def _frequency(chosen: dict, name: str, default: float, faults: list[str]) -> float:
    value = chosen.get(name, default)
    if value is None or value == "none":
        return 0.0
    number = _number(value, f"filter.{name}", faults)
    if number <= 0.0:
        faults.append(f"filter.{name} = {value!r} must be above 0 Hz, or none")
    return number


def _fusion(entry: object, faults: list[str]) -> Fusion:
    given = _mapping(entry or {}, "filter.fusion", tuple(f.name for f in fields(Fusion)), faults)
    values = {key: _number(value, f"filter.fusion.{key}", faults) for key, value in given.items()}
    faults += [
        f"filter.fusion.{key} = {value:g} must lie between 1e-9 and 1e6"
        for key, value in values.items()
        if not 1e-9 <= value <= 1e6
    ]
    return Fusion(**{key: value for key, value in values.items() if key in Fusion.__dataclass_fields__})


def _window(entry: object, faults: list[str]) -> tuple[float, float]:
    window = _mapping(entry, "use", ("from", "to"), faults)
    start = _number(window.get("from", 0.0), "use.from", faults)
    end = _number(window["to"], "use.to", faults) if "to" in window else float("inf")
    if end <= start:
        faults.append(f"use: from {start:g} to {end:g} s is empty")
    return start, end


def _damper(name: str, entry: object, faults: list[str]) -> DamperSignals:
    defaults = default_signals(name)
    given = _mapping(entry or {}, f"dampers.{name}", ROLES, faults)
    spring: dict[str, float] = {}
    channels = {
        role: _channel(f"dampers.{name}.{role}", given[role], getattr(defaults, role), spring, faults)
        for role in ROLES
        if role in given
    }
    return replace(defaults, **channels, **spring)


def _channel(what: str, entry: object, default: Channel, spring: dict[str, float], faults: list[str]) -> Channel:
    of_force, is_slow = what.endswith(".force"), what.endswith((".command", ".temperature", ".pressure"))
    allowed = [f.name for f in fields(Channel) if f.name not in ("limits", "max_age", "given")]
    allowed += ["spring_rate", "preload"] if of_force else ["limits", "max_age"] if is_slow else []
    given = dict(_mapping(entry, what, tuple(allowed), faults))
    values: dict[str, object] = {key: str(given[key]) for key in ("topic", "field", "unit") if key in given}
    si = _UNITS.get(what.rpartition(".")[2])
    if si and values.get("unit", si) != si:
        faults.append(
            f"{what}.unit is {values['unit']}, but values are in {si}: give a scale that converts to it instead"
        )
    values |= {k: _number(given[k], f"{what}.{k}", faults) for k in ("scale", "offset", "skew") if k in given}
    for key in ("spring_rate", "preload"):
        if of_force and key in given:
            spring[key] = _number(given[key], f"{what}.{key}", faults)
    if is_slow and "limits" in given:
        values["limits"] = _limits(f"{what}.limits", given["limits"], faults)
    if is_slow and "max_age" in given:
        values["max_age"] = _number(given["max_age"], f"{what}.max_age", faults)
        if values["max_age"] <= 0.0:
            faults.append(f"{what}.max_age = {given['max_age']!r} must be above 0 s")
    if "table" in given:
        values["table"] = _table(f"{what}.table", given["table"], faults)
        if "scale" in given or "offset" in given:
            faults.append(f"{what} has both a table and a scale or offset; keep one")
    return replace(default, given=True, **values)


def _limits(what: str, entry: object, faults: list[str]) -> tuple[float, float] | None:
    if not isinstance(entry, list) or len(entry) != 2:
        faults.append(f"{what} must be two numbers, the lowest and the highest")
        return None
    low, high = (_number(item, what, faults) for item in entry)
    if not low < high:
        faults.append(f"{what}: {low:g} is not below {high:g}")
    return low, high


def _table(what: str, entry: object, faults: list[str]) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    table = _mapping(entry, what, ("raw", "value"), faults)
    columns = []
    for key in ("raw", "value"):
        column = table.get(key)
        if not isinstance(column, list) or len(column) < 2:
            faults.append(f"{what}.{key} must be a list of two or more numbers")
            return None
        columns.append(tuple(_number(item, f"{what}.{key}", faults) for item in column))
    raw, value = columns
    if len(raw) != len(value) or any(b <= a for a, b in zip(raw, raw[1:], strict=False)):
        faults.append(f"{what}: raw must rise strictly and be as long as value")
        return None
    return raw, value
