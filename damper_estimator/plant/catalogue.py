"""Widely different dampers for trials; magnitudes are typical, none is a copy of a product.

| name | type | force at 0.3 m/s, rebound / compression, gas force included |
| --- | --- | --- |
| `passenger_front` | adjustable monotube of a family car, clear knee | 540 / -720 N (gas -230 N) |
| `rally_rear` | long stroke, large bore, strong, nearly linear | 1030 / -1670 N (gas -500 N) |
| `light_car` | small, digressive: steep at first, flat behind the knee | 280 / -350 N (gas -100 N) |
| `semi_active` | magneto-rheological gap, 0 to 2 A | 500 / -1090 N at 0 A, 1690 / -2260 N at 2 A (gas -330 N) |
"""

from damper_estimator.plant.damper import Damper
from damper_estimator.plant.parts import Coil, Gas, Geometry, Oil, Piston, Seal, Valve

DAMPERS = {
    damper.name: damper
    for damper in (
        Damper(
            name="passenger_front",
            geometry=Geometry(0.036, 0.012, 0.110, 0.130, 0.070, 0.080),
            oil=Oil(bulk_modulus=1.3e9, free_gas=0.004),
            gas=Gas(pressure=21e5, length=0.075),
            piston=Piston(bleed_area=2.4e-6, bleed_transition=4e4, ring_gap=1.1e-11),
            rebound=Valve(2.2e5, 6.0e-12, 7.5e5, 1.6e-11, 1.6e-5),
            compression=Valve(1.1e5, 1.1e-11, 4.5e5, 3.0e-11, 2.2e-5),
            seal=Seal(force=14.0, per_pressure=6e-6),
            adjuster=0.6,
        ),
        Damper(
            name="rally_rear",
            geometry=Geometry(0.046, 0.016, 0.170, 0.210, 0.120, 0.130),
            oil=Oil(bulk_modulus=1.4e9, free_gas=0.003),
            gas=Gas(pressure=26e5, length=0.110, piston_mass=0.2, piston_friction=15.0),
            piston=Piston(bleed_area=3.2e-6, bleed_transition=3e4, ring_gap=2.4e-11),
            rebound=Valve(0.6e5, 6.0e-12, 30e5, 8.0e-12, 3.0e-5, 0.3),
            compression=Valve(0.5e5, 1.0e-11, 19e5, 1.2e-11, 3.6e-5, 0.3),
            seal=Seal(force=30.0, per_pressure=1.0e-5, reach=2e-4),
        ),
        Damper(
            name="light_car",
            geometry=Geometry(0.030, 0.010, 0.100, 0.110, 0.060, 0.065),
            oil=Oil(bulk_modulus=1.1e9, free_gas=0.006),
            gas=Gas(pressure=14e5, length=0.060, piston_mass=0.08, piston_damping=100.0, piston_friction=5.0),
            piston=Piston(bleed_area=1.0e-6, bleed_transition=6e4, ring_gap=1.2e-11),
            rebound=Valve(2.8e5, 1.2e-11, 5.5e5, 3.0e-11, 1.6e-5, 0.1),
            compression=Valve(1.7e5, 2.0e-11, 3.2e5, 5.0e-11, 1.8e-5, 0.1),
            seal=Seal(force=9.0, per_pressure=6e-6, reach=8e-5),
        ),
        Damper(
            name="semi_active",
            geometry=Geometry(0.040, 0.012, 0.110, 0.130, 0.070, 0.075),
            oil=Oil(bulk_modulus=1.2e9, free_gas=0.005, density=2900.0, viscosity_slope=0.012),
            gas=Gas(pressure=30e5, length=0.080),
            piston=Piston(bleed_area=1.0e-5, bleed_transition=2e5, ring_gap=1.5e-10),
            rebound=Valve(3.0e5, 8.0e-12, 9.0e5, 1.5e-11, 3.0e-5),
            compression=Valve(2.5e5, 1.0e-11, 8.0e5, 2.0e-11, 3.0e-5),
            seal=Seal(force=25.0, per_pressure=7e-6),
            coil=Coil(pressure=18e5),
        ),
    )
}
