"""Accuracy of a model outside the region of its fit (status EXTRAPOLATING), on simulated dampers.

    python benchmarks/bench_extrapolation.py [--quick]

Dampers of the catalogue with valves, bleed and gas pressure drawn at random are driven gently (up to 0.25 to 0.55 m/s,
current up to 1 A), each model is fitted to that and judged on the same damper driven 2.2 times as hard (current up to 2
A). A sample's excess is the largest ratio of a channel to its region. The table shows for each model over all dampers:

    sign      share of the samples whose force has the right sign (where the true one is above a tenth of its rms)
    corr      correlation of the modelled with the true force
    slope     of the modelled over the true force, 1 is perfect
    error     rms error over the rms force
    worst     largest error of a single damper
    turned    fits whose force at a steady speed of 1.5 or 2 times the region, in either direction, has the wrong sign
    level     error with the velocity limited to the region's edge: extrapolation must be better
    straight  error with the steady force continued linearly from there, as in exported tables

and the last line shows the inside of the region.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from bench_identification import measurement

from damper_estimator.effects.discovery import find_effect
from damper_estimator.identification import fit
from damper_estimator.model import DamperModel, load_model, make_element
from damper_estimator.model.force_table import steady_force
from damper_estimator.plant import DAMPERS, Damper, Drive, bench_drive, current_steps
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, A, V, X

SECONDS, RATE_STEP = 25.0, 2e-3
GENTLE, ROUGH = (0.2, 0.45), 2.2  # share of the random drive of 10 mm rms, and how many times that
CURRENT = 1.0  # A, up to which a semi-active damper is identified
EXCESS = ((1.0, 1.5), (1.5, 2.0))
PLAIN = (
    "viscous_curve", "wide knots", "force_surface", "wide surface", "carrera_akutain", "memoryless_baseline",
    "bouc_wen", "black_box_3", "black_box_11",
)  # fmt: skip
SEMI_ACTIVE = ("semi_active_yield", "lozoya_santos_simple", "viscous_curve", "wide knots")
WIDE = (-1.2, -0.7, -0.4, -0.2, -0.08, 0.0, 0.08, 0.2, 0.4, 0.7, 1.2)
STEEP = (-120.0, -60.0, -20.0, 0.0, 20.0, 60.0, 120.0)


@dataclass(frozen=True)
class Judged:
    """One model on one damper.

    Attributes:
        force, modelled, level, straight: (n,) N of the rough drive; the last two with the velocity limited to the
            region's edge, and the steady force continued from there.
        excess: (n,) of the channel with the largest excess.
        turned: whether a steady force outside has the wrong sign.
    """

    force: np.ndarray
    modelled: np.ndarray
    level: np.ndarray
    straight: np.ndarray
    excess: np.ndarray
    turned: bool


def some_damper(name: str, seed: int) -> Damper:
    """A damper of the catalogue with modified valves, bleed and gas."""
    damper, rng = DAMPERS[name], np.random.default_rng([seed, 5])
    for part in ("rebound", "compression"):
        valve = getattr(damper, part)
        changed = {field: getattr(valve, field) * rng.uniform(0.7, 1.4) for field in valve._fields[:4]}
        damper = damper.with_part(part, **changed)
    damper = damper.with_part("piston", bleed_area=damper.piston.bleed_area * rng.uniform(0.7, 1.4))
    return damper.with_part("gas", pressure=damper.gas.pressure * rng.uniform(0.8, 1.2))


def driven(damper: Damper, seed: int, scale: float, current: float) -> Measurement:
    """The damper under a random drive; with a coil, the current steps up to ``current`` A."""
    drive_10mm = bench_drive("random10", damper, SECONDS, seed)
    steps = current_steps(SECONDS, seed, highest=current) if damper.coil.pressure > 0.0 else drive_10mm.current
    drive = Drive(drive_10mm.name, drive_10mm.step, scale * drive_10mm.displacement, steps, seed)
    sensed = measurement(damper, drive, int(SECONDS / RATE_STEP) - 2, RATE_STEP, seed)
    if damper.coil.pressure > 0.0:
        time = sensed.kinematics.time
        sensed.kinematics.block[COMMAND] = drive.current[np.searchsorted(drive.time, time - time[0], "right") - 1]
    return sensed


def model_of(name: str) -> DamperModel:
    """From the library, or a curve and a surface with the knots of a data sheet."""
    if not name.startswith("wide"):
        return load_model(name)
    effect, axes = ("viscous_curve", {}) if name == "wide knots" else ("force_surface", {"acceleration": STEEP})
    return DamperModel(name, "this benchmark", (make_element(find_effect(effect), {"velocity": WIDE, **axes}),))


def judged(model: DamperModel, damper: Damper, gentle: Measurement, rough: Measurement) -> Judged:
    """A model fitted to the gentle drive, judged on the rough one."""
    fitted = fit(model, [gentle]).model
    region, block = fitted.fit["region"], rough.kinematics.block
    excess = np.zeros(block.shape[1])
    for name, row in (("displacement", X), ("velocity", V), ("acceleration", A), ("command", COMMAND)):
        if name in region:
            low, high = region[name]
            ratio = np.where(block[row] < low, block[row] / min(low, -1e-9), block[row] / max(high, 1e-9))
            excess = np.fmax(excess, ratio)
    limited = block.copy()
    limited[V] = np.clip(block[V], *region["velocity"])
    level = fitted.force(limited)
    straight = level + _beyond(fitted, region["velocity"], block)
    use = rough.judged
    return Judged(
        rough.in_band(rough.force)[use],
        rough.in_band(fitted.force(block))[use],
        rough.in_band(level)[use],
        rough.in_band(straight)[use],
        excess[use],
        _turned(fitted, damper, region),
    )


def _beyond(fitted: DamperModel, region: list[float], block: np.ndarray) -> np.ndarray:
    """(n,) change by continuing the steady force outside the region of the velocity."""
    command = float(np.mean(block[COMMAND]))
    added = np.zeros(block.shape[1])
    for edge in region:
        inner, outer = (steady_force(fitted, share * edge, 0.0, command) for share in (0.8, 1.0))
        slope = max((outer - inner) / (0.2 * edge), 0.0)
        added += slope * (np.maximum(block[V] - edge, 0.0) if edge > 0.0 else np.minimum(block[V] - edge, 0.0))
    return added


def _turned(fitted: DamperModel, damper: Damper, region: dict) -> bool:
    command = 0.5 * CURRENT if damper.coil.pressure > 0.0 else np.nan
    speeds = [share * edge for share in (1.5, 2.0) for edge in region["velocity"]]
    return any(steady_force(fitted, v, 0.0, command) * v < 0.0 for v in speeds)


def cases(kinds: tuple[str, ...], seeds: int) -> Iterator[tuple[Damper, Measurement, Measurement]]:
    """Random dampers of some kinds, driven gently and roughly."""
    for kind in kinds:
        for seed in range(1, seeds + 1):
            damper = some_damper(kind, seed)
            share = np.random.default_rng([seed, 6]).uniform(*GENTLE)
            gentle = driven(damper, seed, share, CURRENT)
            yield damper, gentle, driven(damper, 100 + seed, ROUGH * share, 2.0 * CURRENT)


def row(found: list[Judged], low: float, high: float) -> str:
    """The figures of a model between two excesses."""
    picked = [(case, (case.excess > low) & (case.excess <= high)) for case in found]
    names = ("force", "modelled", "level", "straight")
    force, modelled, level, straight = (np.concatenate([getattr(o, name)[use] for o, use in picked]) for name in names)
    rms = np.sqrt(np.mean(force**2))
    large = np.abs(force) > 0.1 * rms
    sign = np.mean(np.sign(force[large]) == np.sign(modelled[large]))
    slope = np.polyfit(force, modelled, 1)[0]
    worst = max(_error(case.modelled[use], case.force[use]) for case, use in picked)
    return (
        f"{100 * sign:6.1f} %{np.corrcoef(force, modelled)[0, 1]:7.3f}{slope:7.2f}"
        f"{100 * _error(modelled, force):7.0f} %{100 * worst:6.0f} %{100 * _error(level, force):6.0f} %"
        f"{100 * _error(straight, force):8.0f} %"
    )


def _error(modelled: np.ndarray, force: np.ndarray) -> float:
    return float(np.sqrt(np.mean((modelled - force) ** 2) / np.mean(force**2)))


def show(title: str, kinds: tuple[str, ...], models: tuple[str, ...], seeds: int) -> None:
    """All models on all dampers of some kinds."""
    every = list(cases(kinds, seeds))
    print(f"{title}: {len(every)} dampers")
    print(f"{'':22}{'excess':>12}    sign   corr  slope    error   worst   level   straight   turned")
    for name in models:
        found = [judged(model_of(name), *case) for case in every]
        for low, high in (*EXCESS, (0.0, 1.0)):
            turned = f"{sum(case.turned for case in found):9d}" if low == 1.5 else ""
            label = "inside" if low == 0.0 else f"{low:g} to {high:g}"
            print(f"{name if low == 1.0 else '':22}{label:>12}{row(found, low, high)}{turned}", flush=True)


def main() -> None:
    """Runs everything; --quick uses one damper of each kind."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one damper of each kind instead of four")
    seeds = 1 if parser.parse_args().quick else 4
    plain = tuple(name for name, damper in DAMPERS.items() if damper.coil.pressure == 0.0)
    show("passive dampers", plain, PLAIN, seeds)
    show("semi-active dampers, also current outside", ("semi_active",), SEMI_ACTIVE, seeds)


if __name__ == "__main__":
    main()
