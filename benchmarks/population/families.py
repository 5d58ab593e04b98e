"""Dampers drawn from wide priors: sizes, gas, valves and friction of three families."""

from math import pi, sqrt

import numpy as np

from population.flows import DISCHARGE
from population.plant_parameters import AMBIENT, MAGNETO, MONO, TWIN, Plant


def drawn(rng: np.random.Generator, family: int) -> Plant:
    """A damper with all phenomena at their ordinary size."""
    bore = rng.uniform(0.026, 0.046)
    rod = rng.uniform(0.28, 0.48) * bore if family != TWIN else rng.uniform(0.35, 0.55) * bore
    piston, rod_area, stroke = pi / 4.0 * bore**2, pi / 4.0 * rod**2, rng.uniform(0.05, 0.13)
    annulus = piston - rod_area
    base = Plant(
        family=family,
        piston=piston,
        rod=rod_area,
        stroke=stroke,
        rebound_volume=annulus * (stroke + rng.uniform(0.02, 0.06)),
        compression_volume=piston * (stroke + rng.uniform(0.03, 0.08)),
        density=rng.uniform(830.0, 900.0),
        bulk=rng.uniform(0.9e9, 1.6e9),
        free_gas=_log(rng, 5e-4, 4e-3),
    )
    made = {TWIN: _twin, MONO: _mono, MAGNETO: _magneto}[family](rng, base)
    return _solids(rng, made)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _hole(flow: float, pressure: float, density: float) -> float:
    """Area in m^2 through which ``flow`` passes at ``pressure``."""
    return flow / (DISCHARGE * sqrt(2.0 * pressure / density))


def _valves(rng: np.random.Generator, plant: Plant, strong: float) -> dict[str, float]:
    """Piston valves from a force at 0.3 m/s, a knee, and the share of the force at the knee."""
    annulus, density = plant.piston - plant.rod, plant.density
    knee, share = rng.uniform(0.04, 0.16), rng.uniform(0.35, 0.8)
    forces = {"r": strong, "c": strong * rng.uniform(0.35, 1.0)}
    at_knee = share * strong / annulus
    bleed = _hole(annulus * knee, at_knee, density) * rng.uniform(0.4, 0.9)
    found = {
        "bleed": bleed,
        "transition": at_knee * _log(rng, 0.05, 0.5),
        "leak": annulus * knee / at_knee * rng.uniform(0.05, 0.35),
        "valve_form": int(rng.integers(1, 3)),
        "step": strong / annulus * rng.uniform(0.8, 2.5),
        "step_ratio": rng.uniform(0.2, 0.7),
    }
    for side, force in forces.items():
        full, crack = force / annulus, 0.75 * share * force / annulus
        rest = max(annulus * 0.3 - bleed * DISCHARGE * sqrt(2.0 * full / density), 0.2 * annulus * 0.3)
        area = _hole(rest, full, density)
        found |= {
            f"crack_{side}": crack,
            f"grad_{side}": area / (full - crack),
            f"port_{side}": area * rng.uniform(2, 6),
        }
    return found


def _gas(rng: np.random.Generator, plant: Plant, charge: float) -> dict[str, float]:
    form = int(rng.integers(1, 4))
    return {
        "charge": charge,
        "gas_form": form,
        "gas_volume": plant.rod * plant.stroke * rng.uniform(2.0, 6.0),
        "exponent": rng.uniform(1.2, 1.4),
        "gas_relax": _log(rng, 0.5, 10.0),
        "covolume": rng.uniform(0.05, 0.25),
        "gas_stick": rng.uniform(0.002, 0.02) * charge if form == 3 else 0.0,
    }


def _mono(rng: np.random.Generator, plant: Plant) -> Plant:
    strong = _log(rng, 300.0, 2500.0)
    valves = _valves(rng, plant, strong)
    # The gas keeps the rebound chamber from cavitating in ordinary compression.
    charge = max(rng.uniform(12e5, 30e5), 1.3 * strong / (plant.piston - plant.rod))
    late = {"delay_form": int(rng.integers(1, 4)), "delay": rng.uniform(6e-4, 1.2e-3)} if rng.random() < 0.5 else {}
    placed = {}
    if rng.random() < 0.3:  # a mild bypass that is part of the design
        placed = {"place_form": 1, "place_area": 0.1 * valves["bleed"], "place_width": 0.5 * plant.stroke}
    return plant._replace(**valves, **_gas(rng, plant, charge), **late, **placed)


def _twin(rng: np.random.Generator, plant: Plant) -> Plant:
    strong = _log(rng, 300.0, 1800.0)
    valves = _valves(rng, plant, strong)
    squeeze = strong * rng.uniform(0.3, 0.9) / plant.rod  # Pa over the foot valve at 0.3 m/s
    squeeze = min(squeeze, 50e5)
    flow = plant.rod * 0.3
    area = _hole(flow, squeeze, plant.density)
    foot = {
        "foot_bleed": area * rng.uniform(0.2, 0.5),
        "foot_crack": 0.4 * squeeze,
        "foot_grad": area / (0.6 * squeeze),
        "intake": _hole(plant.rod * 1.0, 0.3e5, plant.density) * rng.uniform(1.0, 3.0),
        # the piston's compression valve is a weak plate: the foot valve makes the force
        "crack_c": rng.uniform(0.3e5, 1.0e5),
        "grad_c": _hole((plant.piston - plant.rod) * 0.3, 2e5, plant.density) / 1.5e5,
        "free_gas": _log(rng, 2e-4, 1.5e-3),
        "foam": _log(rng, 1e-4, 1.5e-3),
    }
    late = {"delay_form": int(rng.integers(1, 4)), "delay": rng.uniform(6e-4, 1.2e-3)} if rng.random() < 0.5 else {}
    return plant._replace(**{**valves, **foot}, **_gas(rng, plant, rng.uniform(3e5, 9e5)), **late)


def _magneto(rng: np.random.Generator, plant: Plant) -> Plant:
    annulus = plant.piston - plant.rod
    low, gain = _log(rng, 40.0, 200.0), _log(rng, 200.0, 1200.0)
    charge = max(rng.uniform(15e5, 35e5), 1.5 * (low + gain) / annulus)
    return plant._replace(
        density=2900.0,
        yield_low=low / annulus,
        yield_gain=gain / annulus,
        gap=_log(rng, 250.0, 1500.0) / annulus**2,
        gap_gain=rng.uniform(0.1, 0.8),
        gap_square=_log(rng, 30.0, 400.0) / annulus**3,
        reach=_log(rng, 1e-4, 8e-4),
        reach_gain=rng.uniform(0.2, 1.5),
        saturation=rng.uniform(0.6, 1.5),
        coil=_log(rng, 4e-3, 3e-2),
        eddy=_log(rng, 3e-2, 0.2),
        leak=annulus * 0.1 / (low + 0.5 * gain) * annulus * rng.uniform(0.02, 0.1),
        warm_yield=rng.uniform(0.0, 0.003),
        **_gas(rng, plant, charge),
    )


def _solids(rng: np.random.Generator, plant: Plant) -> Plant:
    """Friction, joint, masses and the ordinary change with temperature."""
    joint = {}
    if rng.random() < 0.5:
        joint = {"mount_form": int(rng.integers(1, 3)), "mount": _log(rng, 4e6, 1.2e7)}
    return plant._replace(
        rod_mass=rng.uniform(0.2, 0.5),
        rub_form=int(rng.integers(1, 5)),
        rub=_log(rng, 4.0, 30.0),
        rub_extra=rng.uniform(0.05, 0.5),
        rub_speed=_log(rng, 3e-3, 3e-2),
        rub_stiffness=_log(rng, 5e4, 5e5),
        rub_pressure=rng.uniform(0.0, 6e-6),
        rub_side=rng.uniform(-0.2, 0.2),
        mass=rng.uniform(0.1, 0.6),
        warm=rng.uniform(0.008, 0.02),
        warm_form=int(rng.integers(1, 3)),
        warm_gas=1.0 / 303.0,
        **joint,
    )


def tightest(plant: Plant) -> float:
    """m, largest allowed displacement to either side."""
    gas = (plant.gas_volume / plant.rod) * 0.85
    return min(0.85 * plant.stroke, gas)


__all__ = ["AMBIENT", "drawn", "tightest"]
