"""Every phenomenon as a physical change that can be switched off, or on at any strength.

A phenomenon's magnitude m is a physical number; 1 is ordinary. "Off" and "on" differ in nothing else.

| phenomenon | off | on |
| --- | --- | --- |
| `gas_spring` | infinite gas column: constant force | column of ordinary length / m: its pressure follows the rod |
| `friction` | seals without dry friction | m times the seals' force (Stribeck, pre-sliding, loaded by pressure) |
| `oil_compressibility` | stiff oil and walls, 15 GPa | bulk modulus / m, m times the free gas |
| `blow_off` | relief stages never open | they open at 1/m of their ordinary pressure |
| `valve_delay` | discs follow the pressure immediately | their lift lags, first order, by m ms |
| `cavitation` | liquid that withstands tension | vapour limits it; charge towards 1.3 bar by 1/m, degassed (also off) |
| `temperature_fade` | constant oil temperature | dissipated power heats it by 4 m K/kJ; viscosity falls 2.2 % per K |
| `position_dependence` | smooth tube | bypass groove, 16 mm long near mid-stroke, area m times the needle's |
| `end_stop` | none inside the stroke | rubber from 20 % (bump) and 30 % (rebound) of the stroke, 10 m kN/m |
| `mount_compliance` | rigid joint | rubber of 2/m MN/m, progressive, 15 % loss factor at 15 Hz |
| `inertia` | no mass between oil and gauge | m kg move with the rod |
| `asymmetry` | both directions have the (geometric) mean valve | their ratio is the ordinary one to the power m |
| `current` | the coil's field has no effect | yield pressure of m bar (saturated) in the piston gap, lagging 18 ms |
| `hysteresis` | oil flows immediately | gelled oil in the piston yields at m bar after some 4 mm of travel |
| `channel_skew` | synchronous channels | force m ms late |
| `spring_rate_error` | the stated spring rate is true | the true rate is m kN/m higher |
| `force_offset` | gauge's zero is correct | 10 m N off |
| `force_gain_error` | gauge's gain is correct | m per cent high |

The last four can be negative. Heating of m = 1 is that of the oil alone; a larger m compresses a long drive into one
record.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi, sqrt

from damper_estimator.plant.damper import Damper
from damper_estimator.plant.parts import Coil, Gel, Mount, Stops, Valve
from damper_estimator.plant.sensors import Sensors

LOWEST_CHARGE = 1.3e5
"""Pa, gas pressure that ``cavitation`` approaches."""

DEGASSED = 2e-4
"""Share of free gas in the oil that shows cavitation alone."""


@dataclass(frozen=True)
class Setup:
    """A damper and the sensors on it."""

    damper: Damper
    sensors: Sensors


@dataclass(frozen=True)
class Phenomenon:
    """One entry of the vocabulary of findings; ``lowest`` and ``highest`` bound the magnitude."""

    name: str
    lowest: float
    highest: float
    off: Callable[[Setup, float], Setup]
    on: Callable[[Setup, float], Setup]
    signed: bool = False
    """Whether the magnitude can be negative (errors of the measurement chain)."""


def _damper(change: Callable[[Damper, float], Damper]) -> Callable[[Setup, float], Setup]:
    return lambda setup, magnitude: replace(setup, damper=change(setup.damper, magnitude))


def _sensors(change: Callable[[Sensors, float], Sensors]) -> Callable[[Setup, float], Setup]:
    return lambda setup, magnitude: replace(setup, sensors=change(setup.sensors, magnitude))


def _part(part: str, values: Callable[[Damper, float], dict[str, float]]) -> Callable[[Setup, float], Setup]:
    return _damper(lambda damper, magnitude: damper.with_part(part, **values(damper, magnitude)))


def _unchanged(setup: Setup, magnitude: float) -> Setup:
    return setup


def _seal(share: Callable[[float], float]) -> Callable[[Setup, float], Setup]:
    return _part(
        "seal", lambda d, m: {"force": share(m) * d.seal.force, "per_pressure": share(m) * d.seal.per_pressure}
    )


def _relief(change: Callable[[Valve, float], Valve]) -> Callable[[Setup, float], Setup]:
    return _damper(lambda d, m: replace(d, rebound=change(d.rebound, m), compression=change(d.compression, m)))


def _charged(damper: Damper, magnitude: float) -> Damper:
    """Low charge and degassed oil: at such pressures, air would soften it long before it boils."""
    pressure = LOWEST_CHARGE + (damper.gas.pressure - LOWEST_CHARGE) / magnitude
    return damper.with_part("gas", pressure=pressure).with_part("oil", free_gas=DEGASSED)


def _skewed(damper: Damper, magnitude: float) -> Damper:
    """Valves whose numbers all have the ordinary ratio between the directions, to the power ``magnitude``."""
    pairs = list(zip(damper.rebound, damper.compression, strict=True))
    middle = [sqrt(a * b) for a, b in pairs]
    lean = [(a / b) ** (0.5 * magnitude) if a > 0.0 and b > 0.0 else 1.0 for a, b in pairs]
    rebound = Valve(*(m * r for m, r in zip(middle, lean, strict=True)))
    return replace(damper, rebound=rebound, compression=Valve(*(m / r for m, r in zip(middle, lean, strict=True))))


def _stops(damper: Damper, magnitude: float) -> Stops:
    geometry = damper.geometry
    return Stops(-0.2 * geometry.compression_stroke, 0.3 * geometry.rebound_stroke, 1e4 * magnitude)


def _mount(damper: Damper, magnitude: float) -> Mount:
    stiffness = 2e6 / magnitude
    return Mount(stiffness=stiffness, damping=0.15 * stiffness / (2.0 * pi * 15.0))


PHENOMENA = {
    phenomenon.name: phenomenon
    for phenomenon in (
        Phenomenon(
            "gas_spring", 0.05, 100.0,
            _part("gas", lambda d, m: {"length": 100.0}),
            _part("gas", lambda d, m: {"length": d.gas.length / m}),
        ),
        Phenomenon("friction", 1e-2, 60.0, _seal(lambda m: 0.0), _seal(lambda m: m)),
        Phenomenon(
            "oil_compressibility", 1e-2, 30.0,
            _part("oil", lambda d, m: {"bulk_modulus": 1.5e10, "free_gas": 1e-5}),
            _part("oil", lambda d, m: {"bulk_modulus": d.oil.bulk_modulus / m, "free_gas": m * d.oil.free_gas}),
        ),
        Phenomenon(
            "blow_off", 0.05, 30.0,
            _relief(lambda valve, m: valve._replace(relief_gradient=0.0)),
            _relief(lambda valve, m: valve._replace(relief=valve.relief / m)),
        ),
        Phenomenon(
            "valve_delay", 0.05, 60.0,
            _part("piston", lambda d, m: {"lift_time": 0.0}), _part("piston", lambda d, m: {"lift_time": 1e-3 * m}),
        ),
        Phenomenon(
            "cavitation", 0.1, 1e3,
            _damper(lambda d, m: _charged(d, m).with_part("oil", vapour_pressure=-5e7)), _damper(_charged),
        ),
        Phenomenon(
            "temperature_fade", 1e-2, 30.0,
            _part("heat", lambda d, m: {"heating": 0.0}), _part("heat", lambda d, m: {"heating": 4e-3 * m}),
        ),
        Phenomenon(
            "position_dependence", 1e-2, 30.0,
            _part("piston", lambda d, m: {"groove_area": 0.0}),
            _part("piston", lambda d, m: {
                "groove_area": m * d.piston.bleed_area, "groove_centre": 0.004, "groove_width": 0.008,
            }),
        ),
        Phenomenon(
            "end_stop", 1e-2, 50.0,
            _damper(lambda d, m: replace(d, stops=Stops())), _damper(lambda d, m: replace(d, stops=_stops(d, m))),
        ),
        Phenomenon(
            "mount_compliance", 0.02, 50.0,
            _damper(lambda d, m: replace(d, mount=Mount())), _damper(lambda d, m: replace(d, mount=_mount(d, m))),
        ),
        Phenomenon(
            "inertia", 1e-2, 60.0,
            _damper(lambda d, m: replace(d, inertia=0.0)), _damper(lambda d, m: replace(d, inertia=m)),
        ),
        Phenomenon("asymmetry", 1e-2, 6.0, _damper(lambda d, m: _skewed(d, 0.0)), _damper(_skewed)),
        Phenomenon(
            "current", 1e-2, 60.0,
            _damper(lambda d, m: replace(d, coil=Coil())),
            _damper(lambda d, m: replace(d, coil=Coil(pressure=1e5 * m))),
        ),
        Phenomenon(
            "hysteresis", 1e-2, 60.0,
            _damper(lambda d, m: replace(d, gel=Gel())), _damper(lambda d, m: replace(d, gel=Gel(pressure=1e5 * m))),
        ),
        Phenomenon(
            "channel_skew", 1e-2, 20.0,
            _unchanged, _sensors(lambda s, m: replace(s, skew=s.skew + 1e-3 * m)), True,
        ),
        Phenomenon(
            "spring_rate_error", 1e-2, 100.0,
            _unchanged, _sensors(lambda s, m: replace(s, spring_rate_error=s.spring_rate_error + 1e3 * m)), True,
        ),
        Phenomenon(
            "force_offset", 1e-2, 100.0,
            _unchanged, _sensors(lambda s, m: replace(s, force_offset=s.force_offset + 10.0 * m)), True,
        ),
        Phenomenon(
            "force_gain_error", 1e-2, 60.0,
            _unchanged, _sensors(lambda s, m: replace(s, force_gain=s.force_gain * (1.0 + 1e-2 * m))), True,
        ),
    )
}  # fmt: skip
"""By name: the damper's phenomena, then the measurement chain's."""
