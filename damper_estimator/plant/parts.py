"""The parts of a monotube damper: physical parameters in SI units, as the compiled equations read them.

They are named tuples, which the compiler accepts; every value is a float. Displacement is positive in
extension, pressures are absolute, "rebound" is the chamber on the rod's side.
"""

from typing import NamedTuple

AMBIENT_PRESSURE = 101325.0
"""Pa, outside the damper; also where the free gas content of the oil is stated."""

ZERO_CELSIUS = 273.15


class Geometry(NamedTuple):
    """Tube and rod. At displacement 0 the piston stands ``rebound_length`` and ``compression_length`` from the ends."""

    bore: float  # m, diameter of piston and tube
    rod: float  # m, diameter
    rebound_length: float  # m, oil column between piston and rod guide
    compression_length: float  # m, oil column between piston and floating piston
    rebound_stroke: float  # m, largest displacement in extension
    compression_stroke: float  # m, largest displacement in compression, positive
    tail_rod: float = 0.0  # 1, share of the rod's area that also exits at the far end; 1: a through-rod, no gas force


class Oil(NamedTuple):
    """Liquid with a little free gas, which makes it soft at low pressure and lets a void grow at vapour pressure."""

    bulk_modulus: float  # Pa, of the liquid and the walls around it
    free_gas: float  # 1, volume of undissolved gas per volume of liquid at ambient pressure
    vapour_pressure: float = 2000.0  # Pa, lower limit of the chamber pressures
    density: float = 850.0  # kg/m^3
    viscosity_slope: float = 0.022  # 1/K, viscosity falls as exp(-slope (T - 40 deg C))


class Gas(NamedTuple):
    """Gas column behind a floating piston."""

    pressure: float  # Pa, charge at displacement 0 and start temperature
    length: float  # m, column at displacement 0
    exponent: float = 1.3  # 1, polytropic
    piston_mass: float = 0.12  # kg
    piston_damping: float = 150.0  # N s/m, viscous part of its seal
    piston_friction: float = 8.0  # N, dry part of its seal


class Piston(NamedTuple):
    """Passages that are always open, the groove in the tube, and the lag of the valves."""

    bleed_area: float  # m^2, present orifice of the needle, discharge coefficient included
    bleed_transition: float  # Pa, where its laminar and turbulent pressure drops are equal (40 deg C)
    ring_gap: float  # m^3/(s Pa), laminar leak past the piston ring at 40 deg C
    groove_area: float = 0.0  # m^2, bypass groove in the tube, discharge coefficient included
    groove_centre: float = 0.0  # m, displacement at its middle
    groove_width: float = 0.02  # m, half length over which it fades out
    lift_time: float = 0.0  # s, time constant of the shims' lift; 0: they follow the pressure immediately


class Valve(NamedTuple):
    """One direction's disc valve behind its check: main stage, relief stage, and the port both share in series."""

    crack: float  # Pa, main stage opens
    gradient: float  # m^2/Pa, its flow area per pressure above that, discharge coefficient included
    relief: float  # Pa, blow-off stage opens
    relief_gradient: float  # m^2/Pa; 0: it never opens
    port: float  # m^2, discharge coefficient included
    rounding: float = 0.2  # 1, share of the opening pressure, below and above it, over which a stage cracks open


class Seal(NamedTuple):
    """Dry friction of rod seal and piston band: elasto-plastic elements, loaded by the pressure."""

    force: float  # N, sliding, without pressure
    per_pressure: float  # N/Pa, growth with the rebound chamber's pressure above ambient
    stiction: float = 0.35  # 1, share by which breakaway exceeds sliding friction
    stribeck_velocity: float = 0.012  # m/s, at which half of that has faded
    reach: float = 1.2e-4  # m, mean travel before an element slips
    viscous: float = 15.0  # N s/m


class Gel(NamedTuple):
    """Yield pressure of a thixotropic oil in the piston's passages, built up over a travel."""

    pressure: float = 0.0  # Pa
    reach: float = 4e-3  # m, mean piston travel before an element yields


class Coil(NamedTuple):
    """Magneto-rheological gap in the piston: a yield pressure that the coil current raises."""

    pressure: float = 0.0  # Pa, yield pressure far in saturation
    saturation: float = 1.5  # A, half of it is reached at this current
    reach: float = 6e-4  # m, mean piston travel before an element yields
    time: float = 0.018  # s, lag of the field behind the current


class Stops(NamedTuple):
    """Rubber stops on the rod, inside the stroke: k d (1 + (d/progression)^2) (1 + loss d')."""

    compression: float = -1.0  # m, displacement below which the bump stop is touched
    rebound: float = 1.0  # m, displacement above which the rebound stop is touched
    stiffness: float = 0.0  # N/m
    progression: float = 0.012  # m
    loss: float = 0.6  # s/m


class Mount(NamedTuple):
    """Rubber mount between rod and gauge; stiffness 0 means a rigid joint."""

    stiffness: float = 0.0  # N/m
    progression: float = 3e-3  # m, deflection at which the secant stiffness has doubled
    damping: float = 0.0  # N s/m
    rod_mass: float = 0.9  # kg, between mount and oil


class Heat(NamedTuple):
    """Oil temperature from dissipated power: T' = heating P - cooling (T - ambient)."""

    start: float = 40.0  # deg C
    heating: float = 0.0  # K/J; 0: temperature stays at its start
    cooling: float = 1.0 / 400.0  # 1/s
    ambient: float = 40.0  # deg C
