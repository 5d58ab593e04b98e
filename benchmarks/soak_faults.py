"""The fault kinds: changes of messages on their way (`on_states`, `on_slow`), and actions on node and clock (`on_node`,
a generator that advances with every sample).
"""

import importlib.util
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from soak_plant import NAMES
from soak_rule import RACE, STILL
from soak_wire import States


@dataclass(frozen=True)
class Kind:
    """A fault kind.

    Attributes:
        act: its action.
        seconds: shortest and longest duration.
        role: of the slow channel, "displacement", or "" for actions on the node.
        excuse: why the estimator cannot know, "" if the messages reveal it.
        excused_for: s from the beginning.
        needs: module of the project that the node needs to handle it.
        is_fused: whether it needs the accelerometers.
        is_alone: whether it is never combined with another kind.
        is_end: whether the process ends.
        is_unsure: whether the estimator may or may not report the motion as uncertain while it lasts.
    """

    name: str
    act: Callable
    seconds: tuple[float, float]
    role: str
    excuse: str = ""
    excused_for: float = float("inf")
    needs: str = ""
    is_fused: bool = False
    is_alone: bool = False
    is_end: bool = False
    is_unsure: bool = False

    @property
    def is_possible(self) -> bool:
        """Whether the project has the required module."""
        return not self.needs or importlib.util.find_spec(self.needs) is not None


@dataclass
class Fault:
    """A running fault; ``store`` is its memory, ``k`` its number of samples."""

    kind: Kind
    random: np.random.Generator
    dampers: Sequence[int]
    until: float
    began: float = 0.0
    k: int = 0
    store: dict = field(default_factory=dict)
    run: Iterator | None = None
    is_last: bool = False

    def once(self, key: str, make: Callable):
        """The value of ``make``, constant throughout the fault."""
        if key not in self.store:
            self.store[key] = make()
        return self.store[key]

    def chance(self, probability: float) -> bool:
        """Whether a random event happens at this sample."""
        return self.random.random() < probability


KINDS: dict[str, Kind] = {}


def on_states(name: str, low: float = 0.05, high: float = 0.6, **more: object) -> Callable:
    """Registers a change of displacement messages: (fault, message) -> the sent messages."""

    def register(act: Callable[[Fault, States], list[States]]) -> Callable:
        KINDS[f"displacement {name}"] = Kind(f"displacement {name}", act, (low, high), "displacement", **more)
        return act

    return register


def on_slow(role: str, name: str, low: float = 0.1, high: float = 0.8, **more: object) -> Callable:
    """Registers a change of a slow channel: (fault, value, damper) -> the sent values."""

    def register(act: Callable[[Fault, float, int], list[float]]) -> Callable:
        fused = role == "acceleration"
        KINDS[f"{role} {name}"] = Kind(f"{role} {name}", act, (low, high), role, is_fused=fused, **more)
        return act

    return register


def on_node(name: str, low: float = 0.1, high: float = 0.8, **more: object) -> Callable:
    """Registers an action on the node or the clock: a generator over samples, (fault, campaign)."""

    def register(act: Callable) -> Callable:
        KINDS[name] = Kind(name, act, (low, high), "", **more)
        return act

    return register


def _changed(fault: Fault, m: States, change: Callable[[float], float]) -> list[States]:
    values = list(m.values)
    for k in fault.dampers:
        place = m.names.index(NAMES[k]) if NAMES[k] in m.names else len(values)
        if place < len(values):
            values[place] = change(values[place])
    return [replace(m, values=values)]


for _name, _value in {"NaN": np.nan, "infinite": np.inf, "huge": 1e300, "wild": 40.0}.items():

    @on_states(_name, 0.0)
    def _(fault: Fault, m: States, value: float = _value) -> list[States]:
        rate = fault.once("rate", lambda: fault.random.choice([0.05, 1.0]))
        return _changed(fault, m, lambda x: value) if fault.chance(rate) else [m]


FROZEN = "for a moment noise can produce a constant value"


@on_states("stuck", 0.1, 1.0, excuse=FROZEN, excused_for=STILL + RACE)
def _(fault: Fault, m: States) -> list[States]:
    held = fault.once("held", lambda: dict(zip(m.names, m.values, strict=False)))
    values = list(m.values)
    for k in fault.dampers:
        if NAMES[k] in m.names and NAMES[k] in held:
            values[m.names.index(NAMES[k])] = held[NAMES[k]]
    return [replace(m, values=values)]


# The offset is outside the region of the fit.
@on_states("jump", 0.1, 1.0, is_unsure=True)
def _(fault: Fault, m: States) -> list[States]:
    offset = fault.once("offset", lambda: fault.random.choice([-1, 1]) * fault.random.uniform(0.012, 0.3))
    return _changed(fault, m, lambda x: x + offset)


@on_states("outliers")
def _(fault: Fault, m: States) -> list[States]:
    if not fault.chance(0.02):
        return [m]
    offset = fault.random.choice([-1, 1]) * np.exp(fault.random.uniform(np.log(0.002), np.log(0.2)))
    return _changed(fault, m, lambda x: x + offset)


@on_states("noise", is_unsure=True, excuse="a few samples of noise can look like motion", excused_for=0.02)
def _(fault: Fault, m: States) -> list[States]:
    return _changed(fault, m, lambda x: x + 2e-3 * fault.random.standard_normal())


@on_states("duplicates")
def _(fault: Fault, m: States) -> list[States]:
    return [m, m] if fault.chance(0.3) else [m]


@on_states("old stamps")
def _(fault: Fault, m: States) -> list[States]:
    return [m, replace(m, stamp=m.stamp - int(fault.random.uniform(1e6, 9e7)))] if fault.chance(0.1) else [m]


@on_states("gap", 0.02, 0.5)
def _(fault: Fault, m: States) -> list[States]:
    return []


@on_states("half the rate", 0.2, 1.0)
def _(fault: Fault, m: States) -> list[States]:
    return [m] if fault.k % 2 else []


@on_states("uneven", 0.1, 0.6)
def _(fault: Fault, m: States) -> list[States]:
    return [] if fault.chance(0.3) else [m]


@on_states("missing names")
def _(fault: Fault, m: States) -> list[States]:
    gone = {NAMES[k] for k in fault.dampers}
    left = [(n, v) for n, v in zip(m.names, m.values, strict=False) if n not in gone]
    return [replace(m, names=[n for n, _ in left], values=[v for _, v in left])]


@on_states("reordered names")
def _(fault: Fault, m: States) -> list[States]:
    order = fault.random.permutation(len(m.names))
    if len(m.values) < len(m.names):
        return [m]
    return [replace(m, names=[m.names[i] for i in order], values=[m.values[i] for i in order])]


@on_states("extra names")
def _(fault: Fault, m: States) -> list[States]:
    more = [f"stranger_{fault.random.integers(1000)}" for _ in range(fault.random.integers(1, 30))]
    if len(m.values) < len(m.names):
        return [m]
    return [replace(m, names=more + m.names, values=[0.01] * len(more) + m.values)]


@on_states("values missing")
def _(fault: Fault, m: States) -> list[States]:
    return [replace(m, values=m.values[:2])] if fault.chance(0.3) else [m]


@on_states("empty")
def _(fault: Fault, m: States) -> list[States]:
    return [replace(m, names=[], values=[]), m] if fault.chance(0.3) else [m]


@on_states("malformed")
def _(fault: Fault, m: States) -> list[States]:
    raw = b"\0\1\0\0" + fault.random.bytes(7)
    return [m, replace(m, raw=raw, fits=False)] if fault.chance(0.1) else [m]


@on_states("truncated")
def _(fault: Fault, m: States) -> list[States]:
    data = m.data()
    cut = replace(m, raw=data[: fault.random.integers(4, max(len(data) - 8, 5))], fits=False)
    return [cut] if fault.chance(0.1) and m.raw is None else [m]


@on_states("padded", needs="damper_estimator.recordings.padding")
def _(fault: Fault, m: States) -> list[States]:
    return [replace(m, padding=int(fault.random.integers(1, 4)))]


@on_states("other endianness")
def _(fault: Fault, m: States) -> list[States]:
    return [replace(m, is_big=True)]


@on_states("late", 0.65, 1.5)
def _(fault: Fault, m: States) -> list[States]:
    held = fault.once("held", list)
    held.append(m)
    return held if fault.is_last else []


@on_states("burst", 0.02, 0.08)
def _(fault: Fault, m: States) -> list[States]:
    held = fault.once("held", list)
    held.append(m)
    return held if fault.is_last else []


@on_states("flood of strangers")
def _(fault: Fault, m: States) -> list[States]:
    strange = replace(m, names=[f"s{i}" for i in range(40)], values=[0.0] * 40)
    return [strange] * 3 + [m]
