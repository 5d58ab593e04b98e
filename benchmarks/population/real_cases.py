"""Real recordings as cases: an effect hidden in them, an effect removed from their best model, or neither.

Two sets of recordings of magneto-rheological dampers that are not part of the project are read from ``../shared/data``
(or DAMPER_SHARED_DATA). Their noise, their rigs and the errors of the best models are real.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

import damper_estimator as de
from population import families
from population.cases import ATTEMPTS, PHENOMENA, Card
from population.damper_phenomena import IN_THE_DAMPER
from population.drives import RATE, Drive
from population.measurement_chain import FAULTS, Chain, Samples, faulty, gauge, late_by
from population.realisation import scene_of
from population.simulate import Unstable, force_of, in_band, rms, run
from population.strength_search import LEAST_SHOWN, LEVELS, MEDIUM, found

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("DAMPER_SHARED_DATA", ROOT.parent / "shared" / "data"))
HIDDEN = tuple(name for name in PHENOMENA if name not in ("temperature_fade", "current", "hysteresis"))
"""Effects that can be hidden in recordings of a damper with a yield stress at constant temperature and current."""

AMPERES = ("0", "0.25", "0.5", "0.75", "1")


@dataclass(frozen=True)
class Setting:
    """Files of one set, the part of each (from 1), and their common properties."""

    name: str
    columns: str
    files: tuple[str, ...]
    part: int


@dataclass(frozen=True)
class RealCase:
    """Real recordings by role, and the effect hidden in ``fit`` and ``unseen``."""

    setting: str
    chain: Chain
    recordings: dict[str, tuple[Samples, ...]]
    hidden: tuple[str, ...] = ()
    form: str = ""
    size: float = 0.0
    strength: float = 0.0
    shown: float = 0.0
    skew: float = 0.0


def there() -> bool:
    """Whether the recordings exist."""
    return DATA.is_dir()


def settings() -> list[Setting]:
    """Every damper at every command."""
    press = tuple(f"ME{stem}.txt.gz" for stem in ("25mm0x25Hz", "10mm2Hz", "25mm0x5Hz", "5mm3Hz", "2mm5Hz"))
    found = [
        Setting(f"press {ampere} A", "utfsm_mr_damper", press, number + 1) for number, ampere in enumerate(AMPERES)
    ]
    for name, pattern in (("0 V", "ensaio{}.1.mat"), ("0.87 V", "ensaio{}.2.2.mat"), ("1.98 V", "ensaio.B.{}.mat")):
        files = tuple(pattern.format(number) for number in range(1, 11))
        files = tuple(name for name in files if (DATA / "labcontrol_mr_damper" / name).exists())
        found.append(Setting(f"table {name}", "labcontrol_mr_damper", files, 1))
    return found


def drawn(rng: np.random.Generator) -> tuple[Setting, dict[str, tuple[Samples, ...]]]:
    """A setting, and its recordings divided at random into those for the fit and those to judge on."""
    every = settings()
    setting = every[rng.integers(len(every))]
    order = [setting.files[at] for at in rng.permutation(len(setting.files))]
    count = 2 if len(order) <= 5 else 3
    return setting, {
        "base": tuple(read(setting, name) for name in order[:count]),
        "twin": tuple(read(setting, name) for name in order[count : 2 * count + 1]),
    }


def read(setting: Setting, name: str) -> Samples:
    """One unchanged recording in SI units."""
    columns = ROOT / "config" / "columns" / f"{setting.columns}.yaml"
    whole = de.read(str(DATA / setting.columns / name), columns=str(columns))
    part = next(source for source in whole.sources if source.number == min(setting.part, source.parts))
    (channels,) = part.dampers.values()
    time = (part.stamps - part.stamps[0]) * 1e-9
    good = np.isfinite(channels["displacement"]) & np.isfinite(channels["force"])
    force = np.asarray(channels["force"], float)[good]
    current = np.full(good.sum(), float(np.nanmean(channels["command"])))
    return Samples(name, time[good], np.asarray(channels["displacement"], float)[good], force, None, current, force)


def drive_of(samples: Samples) -> Drive:
    """The real motion as a drive: below 35 Hz, with constant current and temperature."""
    grid = np.arange(samples.time[0], samples.time[-1], 1.0 / RATE)
    spread = np.interp(grid, samples.time, samples.x)
    mirrored = np.concatenate([2.0 * spread[0] - spread[:0:-1], spread, 2.0 * spread[-1] - spread[-2::-1]])
    x = in_band(mirrored, cutoff=35.0)[spread.size - 1 : 2 * spread.size - 1]
    v = np.gradient(x, 1.0 / RATE)
    still = np.full(x.size, 30.0)
    return Drive("real", x, v, np.gradient(v, 1.0 / RATE), np.full(x.size, 0.5), still)


def made(card: Card, seed: int) -> RealCase:
    """The case of a card: for an ``effect`` any that can be shown; others as recorded.

    Raises:
        RuntimeError: if no drawn damper shows the hidden effect.
    """
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, 4, card.number, attempt])
        setting, plainly = drawn(rng)
        chain = Chain(round(1.0 / np.median(np.diff(plainly["base"][0].time))), 0, 0, 0, 0, 0, 0, ammeter=True)
        if card.hidden != ("effect",):
            return RealCase(setting.name, chain, {**plainly, "fit": plainly["base"], "unseen": plainly["twin"]})
        try:
            case = _hidden(str(rng.choice(HIDDEN)), card.level, rng, setting, chain, plainly)
        except Unstable:
            continue
        if case is not None:
            return case
    raise RuntimeError(f"{card.name}: no drawn damper shows it")


def _hidden(name: str, level: str, rng, setting, chain, plainly) -> RealCase | None:
    drives = {role: [drive_of(samples) for samples in plainly[role]] for role in ("base", "twin")}
    spread = {role: float(np.concatenate([samples.force for samples in plainly[role]]).std()) for role in drives}
    wanted = LEVELS.get(level, MEDIUM)
    change, (low, high), form, broken = (_chain if name in FAULTS else _damper)(name, rng, chain, drives, plainly)
    if change is None:
        return None

    def strength(size: float, role: str = "base") -> float:
        return rms(np.concatenate([in_band(force) for force in change(size, role)])) / spread[role]

    best = found(strength, wanted, low, high)
    if best is None:
        return None
    size, reached = best
    shown = strength(size, "twin")
    if shown < LEAST_SHOWN * wanted:
        return None
    changed = {
        role: _added(plainly[plain], change(size, plain)) for role, plain in (("fit", "base"), ("unseen", "twin"))
    }
    late = late_by(broken(size)) if name == "channel_skew" else 0.0
    return RealCase(setting.name, chain, {**plainly, **changed}, (name,), form, size, reached, shown, late)


def _damper(name, rng, chain, drives, plainly):
    """Change of the force by a phenomenon of a drawn damper, by size and role."""
    plant = families.drawn(rng, int(rng.integers(0, 3)))
    far = max(np.abs(drive.x).max() for role in drives.values() for drive in role)
    if far > families.tightest(plant):
        raise Unstable("the damper is too short")
    base = drives["base"][0]
    forms = IN_THE_DAMPER[name](plant, scene_of(base, run(plant, base), base), rng)
    if not forms:
        return None, (0.0, 0.0), "", None
    form = forms[rng.integers(len(forms))]

    def change(size: float, role: str) -> list[np.ndarray]:
        return [force_of(form.on(size), drive) - force_of(form.off(size), drive) for drive in drives[role]]

    return change, (form.low, form.high), form.form, lambda size: chain


def _chain(name, rng, chain, drives, plainly):
    """Change of the real force by a fault of the chain, by size and role."""
    _, forms, low, high = FAULTS[name]
    form, sign = int(rng.integers(0, 3)), float(rng.choice([-1.0, 1.0]))

    def broken(size: float) -> Chain:
        return faulty(chain, name, form, sign * size)

    def change(size: float, role: str) -> list[np.ndarray]:
        changes = []
        for drive, samples in zip(drives[role], plainly[role], strict=True):
            force = np.interp(samples.time[0] + drive.time, samples.time, samples.force)
            edge = round(0.1 * RATE)  # a shift must not wrap around
            padded = np.concatenate([np.full(edge, force[0]), force, np.full(edge, force[-1])])
            wide = Drive("real", *(np.pad(values, edge, mode="edge") for values in
                                   (drive.x, drive.v, drive.a, drive.current, drive.temperature)))  # fmt: skip
            changes.append(gauge(broken(size), wide, padded)[edge:-edge] - force)
        return changes

    return change, (low, high), forms[form], broken


def _added(samples: Sequence[Samples], changes: Sequence[np.ndarray]) -> tuple[Samples, ...]:
    """Recordings with changed forces; ``changes`` at ``RATE``."""
    found = []
    for one, change in zip(samples, changes, strict=True):
        grid = one.time[0] + np.arange(change.size) / RATE
        at = CubicSpline(grid, change)(np.clip(one.time, grid[0], grid[-1]))
        found.append(Samples(one.name, one.time, one.x, one.force + at, None, one.current, one.force + at))
    return tuple(found)
