"""Quantities of the columns of a bench file, and their units."""

from collections.abc import Mapping
from dataclasses import dataclass

_INCH = 0.0254
_POUND = 4.4482216152605
_GRAVITY = 9.80665


@dataclass(frozen=True)
class Quantity:
    """A channel of a damper.

    Attributes:
        name: as in a signal map.
        unit: in the bag.
        units: ``(factor, offset)`` by unit name: value in ``unit`` = factor * number + offset.
    """

    name: str
    unit: str
    units: Mapping[str, tuple[float, float]]


def _scaled(**factors: float) -> dict[str, tuple[float, float]]:
    return {name: (factor, 0.0) for name, factor in factors.items()}


QUANTITIES: Mapping[str, Quantity] = {
    quantity.name: quantity
    for quantity in (
        Quantity("displacement", "m", _scaled(m=1.0, cm=1e-2, mm=1e-3, um=1e-6) | {"in": (_INCH, 0.0)}),
        Quantity("force", "N", _scaled(N=1.0, kN=1e3, kgf=_GRAVITY, lbf=_POUND)),
        # A command keeps its unit: a signal map says whether it is A, V or a share.
        Quantity("command", "A", _scaled(A=1.0, mA=1e-3, V=1.0, mV=1e-3) | {"1": (1.0, 0.0), "%": (0.01, 0.0)}),
        Quantity("temperature", "deg C", {"degC": (1.0, 0.0), "C": (1.0, 0.0), "°C": (1.0, 0.0), "K": (1.0, -273.15)}
                 | {"F": (5 / 9, -160 / 9), "degF": (5 / 9, -160 / 9), "°F": (5 / 9, -160 / 9)}),
        Quantity("pressure", "Pa", _scaled(Pa=1.0, kPa=1e3, MPa=1e6, mbar=1e2, bar=1e5, psi=_POUND / _INCH**2)),
        Quantity("acceleration", "m/s^2", {"m/s^2": (1.0, 0.0), "mm/s^2": (1e-3, 0.0), "g": (_GRAVITY, 0.0)}),
    )
}  # fmt: skip

TIME_UNITS: Mapping[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}


def bag_unit(quantity: str, unit: str) -> str:
    """The unit in the bag of a channel in ``unit``."""
    if quantity == "command":
        return {"mA": "A", "mV": "V", "%": "1"}.get(unit, unit)
    return QUANTITIES[quantity].unit
