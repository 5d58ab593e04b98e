"""Phenomena of oil, gas and valves in their realisations."""

import numpy as np

from population.plant_parameters import ENDLESS, MAGNETO, TWIN, Plant
from population.realisation import Realisation, Scene, plain


def gas_spring(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: an infinite column of gas. With: one of 1/m."""
    off = p._replace(gas_form=2, gas_volume=ENDLESS, covolume=0.0, gas_stick=0.0)
    least = 1.15 * max(float(-s.x.min()), 0.02)

    def volume(m: float) -> float:
        return p.rod * (least + p.stroke * 4.0 / m)

    stick = rng.uniform(0.01, 0.04) * p.charge
    return [
        Realisation("heat exchange", lambda m: off, lambda m: off._replace(gas_form=1, gas_volume=volume(m)), 0.1, 300),
        Realisation(
            "covolume", lambda m: off, lambda m: off._replace(covolume=0.3, gas_volume=1.3 * volume(m)), 0.1, 300
        ),
        Realisation(
            "sticking piston", lambda m: off._replace(gas_form=3, gas_stick=stick),
            lambda m: off._replace(gas_form=3, gas_stick=stick, gas_volume=volume(m)), 0.1, 300,
        ),
    ]  # fmt: skip


def friction(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: seals without dry friction. With: m times 10 N and a part that grows with pressure or side force."""
    off = p._replace(rub_form=0)
    more = rng.uniform(0.3, 1.0)  # share that grows with pressure, at the pressure of the drive
    names = {1: "Coulomb under pressure", 2: "Stribeck and side force", 3: "LuGre under pressure", 4: "three contacts"}
    found = []
    for form, name in names.items():
        side = rng.uniform(-0.6, 0.6) if form in (2, 4) else 0.0
        plant = off._replace(rub_form=form, rub_side=side)
        push = more if form in (1, 3) else 0.0

        def on(m: float, plant: Plant = plant, push: float = push) -> Plant:
            return plant._replace(rub=10.0 * m, rub_pressure=10.0 * m * push / (s.pressure + p.charge))

        found.append(Realisation(name, lambda m: off, on, 0.1, 200))
    return found


def oil_compressibility(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: stiff oil without gas. With: softer oil, gas in it, a soft wall, or foam from long work."""
    off = p._replace(bulk=1.5e10, free_gas=1e-5, foam=0.0, wall=0.0)
    found = [
        plain("bulk modulus", off, 0.05, 60, bulk=lambda m: 1.0 / (1.0 / 1.5e10 + m / 1.2e9)),
        plain("free gas", off, 0.02, 20, free_gas=lambda m: 4e-3 * m),
        plain("hose", off, 0.05, 60, wall=lambda m: m / 1.0e9),
    ]
    if p.family == TWIN:
        found.append(plain("foam", off._replace(free_gas=2e-4), 0.02, 60, foam=lambda m: 5e-3 * m))
    return found


def blow_off(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: no relief passage. With: one that opens beyond a pressure, m wide."""
    off = p._replace(blow_form=0, blow_pressure=s.pressure * rng.uniform(0.3, 0.6), blow_side=int(rng.integers(1, 4)))
    if p.family == TWIN:
        off = off._replace(blow_side=1)  # in compression the foot valve produces the pressure
    wide = 1e-6 / s.pressure
    names = {1: "poppet with flow force", 2: "shims", 3: "spool"}
    found = []
    for form, name in names.items():
        plant = off._replace(blow_form=form)
        found.append(plain(name, plant, 0.02, 200, blow_gain=lambda m: wide * m))
        found[-1] = Realisation(name, lambda m: off, found[-1].on, 0.02, 200)
    return found


def valve_delay(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: valves follow the pressure immediately. With: late by about m ms (pushed shut: less)."""
    if p.family == MAGNETO:
        return []
    off = p._replace(delay_form=0)
    longest = {"valve mass": 25, "squeeze film": 25, "pilot chamber": 25, "closes late": 150}
    return [
        Realisation(name, lambda m: off, lambda m, form=form: off._replace(delay_form=form, delay=1e-3 * m), 0.5, most)
        for form, (name, most) in enumerate(longest.items(), start=1)
    ]


def cavitation(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: oil that withstands tension. With: vapour or air below a pressure; the charge is too low by m in
    both."""

    def charged(m: float) -> Plant:
        return p._replace(charge=max(p.charge / m, 1.15e5), free_gas=3e-4, foam=0.0)

    def off(m: float) -> Plant:
        return charged(m)._replace(low=8e5, vapour=-1e12)

    found = [
        Realisation("vapour", off, lambda m: charged(m)._replace(low=1e5, vapour=5e3), 1.0, 60),
        Realisation("air", off, lambda m: charged(m)._replace(low=2.5e4, vapour=-1e12, free_gas=4e-3), 1.0, 60),
        Realisation("gas set free", off, lambda m: charged(m)._replace(low=6e4, vapour=5e3, release=20.0), 1.0, 60),
    ]
    if p.family == TWIN:
        narrow = [
            Realisation(
                form.form + ", narrow intake", lambda m, form=form: form.off(1.0)._replace(intake=p.intake / m),
                lambda m, form=form: form.on(1.0)._replace(intake=p.intake / m), 1.0, 60,
            )
            for form in found[:2]
        ]  # fmt: skip
        found += narrow
    return found


def hysteresis(p: Plant, s: Scene, rng: np.random.Generator) -> list[Realisation]:
    """Without: oil without memory. With: a gel's pressure of m times 20 kPa."""
    off = p._replace(gel_form=0, gel_reach=rng.uniform(6e-4, 3e-3), gel_time=rng.uniform(0.3, 3.0))
    names = {1: "layers", 2: "relaxing", 3: "thixotropic"}
    return [
        Realisation(name, lambda m: off, lambda m, form=form: off._replace(gel_form=form, gel=2e4 * m), 0.05, 400)
        for form, name in names.items()
    ]
