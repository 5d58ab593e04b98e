"""All phenomena in the damper: imports those of oil, gas and valves, defines the others."""

import numpy as np

from population.common_step import steady_field
from population.hydraulic import (
    blow_off,
    cavitation,
    friction,
    gas_spring,
    hysteresis,
    oil_compressibility,
    valve_delay,
)
from population.plant_parameters import MAGNETO, Plant
from population.realisation import Realisation, Scene, plain
from population.simulate import lightest


def temperature_fade(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: no dependence on temperature. With: m times the ordinary one, of oil with a large laminar share."""
    thin = p._replace(leak=3.0 * p.leak, bleed=0.6 * p.bleed, transition=min(4.0 * p.transition, 0.7 * s.pressure))
    off = thin._replace(warm=0.0, warm_gas=0.0, warm_yield=0.0)
    if p.family == MAGNETO:
        off = p._replace(warm=0.0, warm_gas=0.0, warm_yield=0.0)
        return [
            plain("viscosity", off, 0.1, 4, warm=lambda m: 0.02 * m),
            plain("yield stress and viscosity", off, 0.1, 5, warm=lambda m: 0.01 * m, warm_yield=lambda m: 0.005 * m),
            plain("viscosity and gas", off._replace(warm_form=2), 0.1, 4, warm=lambda m: 0.02 * m,
                   warm_gas=lambda m: 0.01 * m),
        ]  # fmt: skip
    return [
        plain("viscosity", off._replace(warm_form=1), 0.1, 4, warm=lambda m: 0.02 * m),
        plain("viscosity after Vogel", off._replace(warm_form=2), 0.1, 4, warm=lambda m: 0.02 * m),
        plain("gas", off, 0.1, 10, warm_gas=lambda m: 0.006 * m),
        plain("viscosity and gas", off, 0.1, 4, warm=lambda m: 0.018 * m, warm_gas=lambda m: 0.006 * m),
    ]


def position_dependence(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: a smooth tube. With: position-dependent passages, in exchange for part of the bleed."""
    span = s.high - s.low
    hole = p.bleed if p.family != MAGNETO else 2e-6
    found = []
    for form, name in {1: "groove", 2: "ports with a check", 3: "metering pin"}.items():
        centre = s.low + span * rng.uniform(0.25, 0.75)
        plant = p._replace(place_form=form, place_centre=centre, place_width=max(span * rng.uniform(0.12, 0.3), 4e-3))
        off = p._replace(place_form=0)

        def on(m: float, plant: Plant = plant) -> Plant:
            area = hole * m
            mean = area * _mean_passage(plant, s.x)
            return plant._replace(place_area=area, bleed=max(p.bleed - mean, 0.15 * p.bleed))

        found.append(Realisation(name, lambda m, off=off: off, on, 0.03, 60))
    return found


def _mean_passage(p: Plant, x: np.ndarray) -> float:
    """Mean over a drive of the open share of position-dependent passages."""
    if p.place_form == 1:
        return float(np.clip((1.4 * p.place_width - np.abs(x - p.place_centre)) / (0.4 * p.place_width), 0, 1).mean())
    if p.place_form == 2:
        return 0.5 * float((np.clip((x - p.place_centre) / (2 * p.place_width) + 0.5, 0, 1) ** 1.5).mean())
    return float((1.0 / (1.0 + 6.0 * ((x - p.place_centre) / p.stroke) ** 2)).mean())


def end_stop(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: nothing inside the stroke. With: a stop of m times 20 kN/m that the drive reaches."""
    low, high = np.quantile(s.x, [rng.uniform(0.01, 0.08), 1.0 - rng.uniform(0.01, 0.08)])
    which = int(rng.integers(0, 3))
    plant = p._replace(stop_low=float(low) if which != 1 else -1.0, stop_high=float(high) if which != 0 else 1.0)
    names = {1: "foam", 2: "hydraulic", 3: "steel spring"}
    return [
        Realisation(
            name, lambda m: p._replace(stop_form=0),
            lambda m, form=form: plant._replace(stop_form=form, stop=2e4 * m), 0.02, 200,
        )
        for form, name in names.items()
    ]  # fmt: skip


def mount_compliance(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: a rigid joint. With: one with a softness of m."""
    found = []
    for form, name in {1: "hardening rubber", 2: "filled rubber", 3: "worn bush"}.items():
        plant = p._replace(mount_form=form, mount_loss=rng.uniform(0.05, 0.2))

        def on(m: float, plant: Plant = plant) -> Plant:
            soft = plant._replace(mount=3e6 / m, mount_gap=1e-4 * m)
            if plant.mount_form == 3:
                soft = soft._replace(mount=4e6)
            return soft._replace(rod_mass=lightest(plant._replace(mount=1e7)))

        found.append(Realisation(name, lambda m, on=on: on(m)._replace(mount_form=0), on, 0.3, 60))
    return found


def inertia(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: a light rod. With: m kg that ring, are moved by a lever, or are oil in a hose."""
    off = p._replace(mass_form=1, mass=0.0, rod_mass=0.15, mount_form=0)
    ring, lever = rng.uniform(70.0, 160.0), rng.uniform(-0.8, 0.8)
    return [
        Realisation(name, lambda m: off, lambda m, plant=plant: plant._replace(mass=m), 0.05, 40)
        for name, plant in {
            "ringing mass": off._replace(mass_form=2, mass_ring=ring),
            "lever": off._replace(mass_form=3, mass_lever=lever),
            "oil in a hose": off._replace(mass_form=4),
        }.items()
    ]


def asymmetry(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: the damper as drawn. With: one direction harder and the other softer, or a passage with a check."""
    found = [plain("passage with a check", p, 0.02, 100, check_c=lambda m: 1e-6 * m)]
    found[0] = Realisation("passage with a check", lambda m: p._replace(check_c=0.0), found[0].on, 0.02, 100)
    if p.family == MAGNETO:
        return found
    turned = 1.0 if rng.random() < 0.5 else -1.0

    def preloads(m: float) -> Plant:
        k = (1.0 + m) ** turned
        return p._replace(crack_r=p.crack_r * k, crack_c=p.crack_c / k, foot_crack=p.foot_crack / k)

    def stacks(m: float) -> Plant:
        k = (1.0 + m) ** turned
        return p._replace(
            grad_r=p.grad_r / k,
            port_r=p.port_r / k,
            grad_c=p.grad_c * k,
            port_c=p.port_c * k,
            foot_grad=p.foot_grad * k,
        )

    found += [
        Realisation("preloads", lambda m: p, preloads, 0.01, 10),
        Realisation("stacks", lambda m: p, stacks, 0.01, 10),
    ]
    return found


def current(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: the current has no effect, and the damper is as at the base recording's. With: m times the ordinary
    effect.
    """
    if p.family == MAGNETO:
        names = {1: "coil's lag and saturation", 2: "eddy currents", 3: "remanence"}
        idle = {form: steady_field(form, s.current / p.saturation) for form in names}
        return [
            Realisation(
                name,
                lambda m, form=form: p._replace(
                    current_form=0, yield_gain=p.yield_gain * m, gap_gain=p.gap_gain * m, idle=idle[form]
                ),
                lambda m, form=form: p._replace(
                    current_form=form, yield_gain=p.yield_gain * m, gap_gain=p.gap_gain * m
                ),
                0.02, 6,
            )
            for form, name in names.items()
        ]  # fmt: skip
    plant = p._replace(saturation=rng.uniform(1.0, 3.0))
    needle, valves = (steady_field(form, s.current / plant.saturation) for form in (4, 5))
    return [
        Realisation(
            "needle in the bleed", lambda m: plant._replace(bleed=1.4 * p.bleed),
            lambda m: plant._replace(current_form=4, current=m, bleed=1.4 * p.bleed / max(1 - needle * m, 0.4)),
            0.05, 1.2,
        ),
        Realisation(
            "preload of the valves", lambda m: plant,
            lambda m: plant._replace(
                current_form=5, current=m, crack_r=p.crack_r / (1 + valves * m), crack_c=p.crack_c / (1 + valves * m)
            ), 0.05, 6,
        ),
    ]  # fmt: skip


IN_THE_DAMPER = {
    phenomenon.__name__: phenomenon
    for phenomenon in (
        gas_spring, friction, oil_compressibility, blow_off, valve_delay, cavitation, temperature_fade,
        position_dependence, end_stop, mount_compliance, inertia, asymmetry, current, hysteresis,
    )
}  # fmt: skip
