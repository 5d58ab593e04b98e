"""Fault kinds of the slow channels, the gauge and the desired forces."""

from collections.abc import Callable

import numpy as np
from soak_faults import Fault, on_slow

SLOW_KINDS = {
    "silent": lambda v: [],
    "NaN": lambda v: [np.nan],
    "infinite": lambda v: [-np.inf],
    "wild": lambda v: [65535.0],
}

for _role in ("current", "temperature", "pressure", "acceleration"):
    for _name, _act in SLOW_KINDS.items():
        if _role == "acceleration" and _name == "infinite":
            continue

        @on_slow(_role, _name)
        def _(fault: Fault, value: float, k: int, act: Callable = _act) -> list[float]:
            return act(value)


@on_slow("current", "absurd")
def _(fault: Fault, value: float, k: int) -> list[float]:
    return [1e300]


@on_slow("current", "NaN now and then")
def _(fault: Fault, value: float, k: int) -> list[float]:
    return [np.nan] if fault.chance(0.1) else [value]


@on_slow("current", "stuck")
def _(fault: Fault, value: float, k: int) -> list[float]:
    return [fault.once(f"held {k}", lambda: value)]


@on_slow("current", "late")
def _(fault: Fault, value: float, k: int) -> list[float]:
    queue = fault.once(f"queue {k}", list)
    queue.append(value)
    return [queue.pop(0)] if len(queue) > 25 else []


@on_slow("current", "another unit")
def _(fault: Fault, value: float, k: int) -> list[float]:
    return [1000.0 * value if fault.once("scale", lambda: fault.chance(0.5)) else 0.001 * value]


@on_slow("temperature", "stuck", excuse="a constant temperature is normal")
def _(fault: Fault, value: float, k: int) -> list[float]:
    return [fault.once(f"held {k}", lambda: value)]


@on_slow("acceleration", "offset", excuse="an offset occurs naturally and is detected within a second")
def _(fault: Fault, value: float, k: int) -> list[float]:
    return [value + fault.once("offset", lambda: fault.random.uniform(-3.0, 3.0))]


for _name, _act in SLOW_KINDS.items():

    @on_slow("gauge", _name)
    def _(fault: Fault, value: float, k: int, act: Callable = _act) -> list[float]:
        return act(value)


for _name, _value in {"NaN": np.nan, "infinite": np.inf, "huge": 1e300, "-huge": -1e9}.items():

    @on_slow("desired force", _name)
    def _(fault: Fault, value: float, k: int, desired: float = _value) -> list[float]:
        return [desired]


@on_slow("desired force", "silent", 0.2, 1.0)
def _(fault: Fault, value: float, k: int) -> list[float]:
    return []


@on_slow("desired force", "flood")
def _(fault: Fault, value: float, k: int) -> list[float]:
    return [value] * 10
