"""All numbers of a damper of any family; replacing some of them switches a phenomenon on.

Displacement x in m is positive in extension, the force in N positive where it resists extension. Pressures are
absolute. A ``*_form`` chooses between realisations that differ in their equations; 0 is none.
"""

from typing import NamedTuple

AMBIENT = 1.013e5
TWIN, MONO, MAGNETO = 0, 1, 2
FAMILIES = ("twin_tube", "monotube", "magneto")
ENDLESS = 1e6  # m^3 of gas: its pressure does not follow the rod


class Plant(NamedTuple):
    """One damper; SI units."""

    family: int
    piston: float  # m^2
    rod: float  # m^2
    stroke: float  # m to either side of x = 0
    rebound_volume: float  # m^3 at x = 0
    compression_volume: float
    density: float = 860.0
    # Oil: s(p) = p / bulk + wall + gas; below ``low`` the gas has a constant compliance.
    bulk: float = 1.3e9
    free_gas: float = 2e-3
    low: float = 2e4
    vapour: float = 3e3
    wall: float = 0.0  # 1/Pa, hose or tube wall at zero pressure
    wall_pressure: float = 2e6  # beyond which it hardens
    foam: float = 0.0  # share of gas entrained by a minute of work
    release: float = 0.0  # 1/s, gas released from solution below ambient pressure
    # Gas behind the floating piston, or in the reserve.
    gas_form: int = 1
    charge: float = 2e6
    gas_volume: float = ENDLESS
    exponent: float = 1.35
    gas_relax: float = 3.0  # s, heat exchange with the wall
    covolume: float = 0.0  # incompressible share of the volume
    gas_stick: float = 0.0  # Pa, friction of the floating piston
    # Passages through the piston.
    leak: float = 1e-11  # m^3/s/Pa, laminar
    bleed: float = 2e-6  # m^2
    transition: float = 4e4  # Pa, below which the bleed is laminar
    valve_form: int = 1
    crack_r: float = 5e5
    crack_c: float = 3e5
    grad_r: float = 2e-11  # m^2/Pa
    grad_c: float = 3e-11
    port_r: float = 3e-5
    port_c: float = 3e-5
    step: float = 2e6  # Pa, where the stack stiffens, or the spool's flow force matters
    step_ratio: float = 0.4
    check_c: float = 0.0  # m^2, a passage open only in compression
    # Foot valve (twin tube).
    foot_bleed: float = 2e-6
    foot_crack: float = 3e5
    foot_grad: float = 3e-11
    intake: float = 5e-5  # m^2
    # Late valves.
    delay_form: int = 0
    delay: float = 0.0  # s
    # Blow-off: opens beyond a pressure in the directions 1 rebound, 2 compression, 3 both.
    blow_form: int = 0
    blow_side: int = 3
    blow_pressure: float = 1e9
    blow_gain: float = 0.0  # m^2/Pa
    # Position-dependent passages.
    place_form: int = 0
    place_area: float = 0.0
    place_centre: float = 0.0
    place_width: float = 0.02
    # Temperature.
    warm_form: int = 1  # viscosity: 1 exponential, 2 Vogel
    warm: float = 0.02  # 1/K
    warm_gas: float = 0.0  # 1/K, relative rise of the gas's pressure
    warm_yield: float = 0.0  # 1/K
    # Current.
    current_form: int = 0
    current: float = 0.0  # relative effect
    saturation: float = 1.0  # A
    coil: float = 0.01  # s
    eddy: float = 0.08  # s
    idle: float = 0.5  # field without an acting current
    # Magneto-rheological gap.
    yield_low: float = 2e5  # Pa
    yield_gain: float = 6e5
    gap: float = 2e9  # Pa s/m^3
    gap_gain: float = 0.4
    gap_square: float = 0.0  # Pa s^2/m^6
    reach: float = 4e-4  # m of the oil's travel
    reach_gain: float = 0.8
    # Fluid with memory.
    gel_form: int = 0
    gel: float = 0.0  # Pa
    gel_reach: float = 1e-3  # m
    gel_time: float = 1.0  # s
    # Dry friction.
    rub_form: int = 3
    rub: float = 15.0  # N
    rub_extra: float = 0.3  # static over sliding, less 1
    rub_speed: float = 0.01  # m/s
    rub_stiffness: float = 2e5  # N/m
    rub_pressure: float = 0.0  # N/Pa
    rub_side: float = 0.0  # relative, at full stroke
    # Joint between the gauge and the rod.
    mount_form: int = 0
    mount: float = 1e7  # N/m
    mount_loss: float = 0.15
    mount_gap: float = 1e-4  # m
    rod_mass: float = 0.3  # kg, behind the joint, or moved with the rod if that is rigid
    # Mass between the gauge and the oil.
    mass_form: int = 1
    mass: float = 0.5  # kg
    mass_ring: float = 120.0  # Hz
    mass_lever: float = 0.0
    # Stops.
    stop_form: int = 0
    stop_low: float = -1.0  # m
    stop_high: float = 1.0
    stop: float = 0.0  # N/m
