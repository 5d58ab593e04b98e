"""A complete simulated damper: its parts, derived areas and volumes, and its state at rest."""

from dataclasses import dataclass, replace
from math import pi
from typing import NamedTuple

from damper_estimator.plant.parts import (
    AMBIENT_PRESSURE,
    Coil,
    Gas,
    Gel,
    Geometry,
    Heat,
    Mount,
    Oil,
    Piston,
    Seal,
    Stops,
    Valve,
)


@dataclass(frozen=True)
class Damper:
    """Physical parameters of one monotube damper; ``parts`` documents each with its unit.

    ``adjuster`` is the opening of the bleed needle, 0 (hard) to 1 (soft); it scales ``piston.bleed_area`` from 20 % up.
    ``inertia`` is the effective mass in kg at the gauge that moves with the rod or in long passages.
    """

    name: str
    geometry: Geometry
    oil: Oil
    gas: Gas
    piston: Piston
    rebound: Valve
    compression: Valve
    seal: Seal
    gel: Gel = Gel()
    coil: Coil = Coil()
    stops: Stops = Stops()
    mount: Mount = Mount()
    heat: Heat = Heat()
    inertia: float = 0.0
    adjuster: float = 1.0

    def with_part(self, part: str, **values: float) -> "Damper":
        """The damper with some parameters of one part replaced, such as ``with_part("oil", bulk_modulus=8e8)``."""
        return replace(self, **{part: getattr(self, part)._replace(**values)})


class Chambers(NamedTuple):
    """Areas and volumes at displacement 0; ``*_excess`` is liquid (at zero pressure) less volume."""

    piston_area: float  # m^2
    rebound_area: float  # m^2
    compression_area: float  # m^2
    rebound_volume: float  # m^3
    compression_volume: float  # m^3
    gas_volume: float  # m^3
    rebound_excess: float  # m^3
    compression_excess: float  # m^3


class Parts(NamedTuple):
    """All inputs of the compiled equations."""

    chambers: Chambers
    oil: Oil
    gas: Gas
    piston: Piston
    rebound: Valve
    compression: Valve
    seal: Seal
    gel: Gel
    coil: Coil
    stops: Stops
    mount: Mount
    heat: Heat
    inertia: float


def parts_of(damper: Damper) -> Parts:
    """The damper's parts with computed areas and volumes, all numbers floats (the compiler requires one type)."""
    needle = damper.piston.bleed_area * (0.2 + 0.8 * damper.adjuster)
    parts = Parts(
        chambers=_chambers(damper),
        oil=damper.oil,
        gas=damper.gas,
        piston=damper.piston._replace(bleed_area=needle),
        rebound=damper.rebound,
        compression=damper.compression,
        seal=damper.seal,
        gel=damper.gel,
        coil=damper.coil,
        stops=damper.stops,
        mount=damper.mount,
        heat=damper.heat,
        inertia=float(damper.inertia),
    )
    return Parts(*(type(part)(*map(float, part)) if isinstance(part, tuple) else part for part in parts))


def _chambers(damper: Damper) -> Chambers:
    geometry = damper.geometry
    piston = pi / 4 * geometry.bore**2
    rod = pi / 4 * geometry.rod**2
    excess = packed_share(damper.oil, damper.gas.pressure)
    rebound, compression = (piston - rod) * geometry.rebound_length, piston * geometry.compression_length
    return Chambers(
        piston_area=piston,
        rebound_area=piston - rod,
        compression_area=piston - rod * geometry.tail_rod,
        rebound_volume=rebound,
        compression_volume=compression,
        gas_volume=piston * damper.gas.length,
        rebound_excess=rebound * excess,
        compression_excess=compression * excess,
    )


def packed_share(oil: Oil, pressure: float) -> float:
    """Liquid in excess of the chamber's volume, per volume, at ``pressure``: p'/B - free_gas p_ambient / p'.

    p' is the pressure above vapour pressure, B the bulk modulus: compressed liquid less the volume of isothermal gas.
    """
    above = pressure - oil.vapour_pressure
    return above / oil.bulk_modulus - oil.free_gas * AMBIENT_PRESSURE / above
