"""Cases drawn at random: hidden effect, damper, drive and sensors; and their recordings."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from population import drives, families, measurement_chain
from population.damper_phenomena import IN_THE_DAMPER
from population.drives import Drive
from population.measurement_chain import FAULTS, Chain, Samples, late_by, sampled
from population.plant_parameters import FAMILIES, MAGNETO, MONO, TWIN, Plant
from population.realisation import scene_of
from population.simulate import Unstable, force_of, in_band, rms, run, share
from population.strength_search import LEAST_SHOWN, LEVELS, MEDIUM, Switched, in_chain, in_damper, shown

PHENOMENA = (*IN_THE_DAMPER, *FAULTS)
ALIKE = (
    {"channel_skew", "valve_delay", "oil_compressibility", "mount_compliance"},
    {"friction", "hysteresis"},
    {"gas_spring", "spring_rate_error", "force_offset"},
)
"""Pairs too similar to be separate findings in one recording."""

ATTEMPTS = 60
_HELD = 0.3  # of the dampers whose temperature or current acts: neither changes within a recording
MOST_SHOWN = 3.0
"""Of the wanted strength, on the unseen recording."""


@dataclass(frozen=True)
class Card:
    """Specification of a case: ``kind`` hidden, nothing, pair or real; ``hidden`` names the effects to be found."""

    number: int
    kind: str
    hidden: tuple[str, ...]
    level: str
    against: bool = False

    @property
    def name(self) -> str:
        """Unique in the run."""
        return f"{self.number:04d}-{self.kind}-{'+'.join(self.hidden) or 'nothing'}-{self.level}"


@dataclass(frozen=True)
class Case:
    """A generated case.

    Attributes:
        effects: hidden effects with form, size and strength on the fit recording.
        shown: strength on the unseen recording.
        base, fit, unseen, twin: recordings; base and twin are without the effect, twin with the drive of unseen.
        skew: s, delay of the force in fit and unseen.
    """

    card: Card
    family: str
    drive: tuple[str, str]
    seconds: float
    effects: tuple[Switched, ...]
    shown: float
    chain: Chain
    base: Samples
    fit: Samples
    unseen: Samples
    twin: Samples
    skew: float
    attempts: int


def deck(seed: int, real: bool) -> Iterator[Card]:
    """Infinite cards: every 28 contain each phenomenon once, three without any, four pairs and three real ones."""
    rng, number = np.random.default_rng([seed, 1]), 0
    while True:
        cards = [("hidden", (name,), str(rng.choice(list(LEVELS), p=[0.25, 0.5, 0.25])), False) for name in PHENOMENA]
        cards += [("nothing", (), "none", False)] * 3 + [("pair", _pair(rng), "medium", False) for _ in range(3)]
        cards.append(("pair", ("inertia", "channel_skew"), "medium", True))
        if real:
            cards += [("real", ("ablation",), "none", False), ("real", (), "none", False)]
            cards.append(("real", ("effect",), "medium", False))
        for at in rng.permutation(len(cards)):
            yield Card(number, *cards[at])
            number += 1


def _pair(rng: np.random.Generator) -> tuple[str, str]:
    while True:
        first, second = (str(name) for name in rng.choice(PHENOMENA, 2, replace=False))
        if not any({first, second} <= alike for alike in ALIKE) and not {first, second} <= set(FAULTS):
            return (second, first) if first in FAULTS else (first, second)


def made(card: Card, seed: int, longest: float = 120.0) -> Case:
    """The case of a card, with the first drawn damper and drive that can show the hidden effect.

    Raises:
        RuntimeError: if none of many can.
    """
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, 2, card.number, attempt])
        try:
            case = _tried(card, rng, longest, attempt)
        except Unstable:
            continue
        if case is not None:
            return case
    raise RuntimeError(f"{card.name}: no drawn damper shows it")


def _tried(card: Card, rng: np.random.Generator, longest: float, attempt: int) -> Case | None:
    family = int(rng.choice([TWIN, MONO, MAGNETO], p=[0.35, 0.4, 0.25]))
    plant = families.drawn(rng, family)
    moves = family == MAGNETO and "current" not in card.hidden and rng.random() < 0.35
    acts = "current" in card.hidden
    if family == MAGNETO and not acts:
        plant = plant._replace(current_form=int(rng.integers(1, 4)))
    setting = _setting(card, rng, plant, longest, moves or acts)
    slow = {"temperature_fade": _warmer, "current": _at_another_current}.get("+".join(card.hidden))
    held = slow is not None and bool(rng.random() < _HELD)
    if held:
        setting = slow(rng, setting)
    first, base, _ = setting
    out = run(plant, first[1])
    spread = float(out[:, 0].std())
    coil_over = rng.random() < (0.7 if "spring_rate_error" in card.hidden else 0.2)
    chain = _with_slow_channels(card, rng, measurement_chain.drawn(rng, spread, coil_over), first[1], moves or acts)
    chain = replace(chain, thermometer=True) if held else chain
    effects = _hidden(card, rng, plant, chain, first[1], scene_of(first[1], out, base[1]))
    if effects is None:
        return None
    if held:
        effects = tuple(replace(effect, form=f"{effect.form}, constant") for effect in effects)
    off = effects[0].off if effects else (plant, chain)
    on = effects[-1].on if effects else (plant, chain)
    return _recorded(card, rng, setting, effects, off, on, attempt)


def _setting(
    card: Card, rng: np.random.Generator, plant: Plant, longest: float, current: bool
) -> list[tuple[str, Drive]]:
    """Drives of fit, base and unseen recording."""
    kinds = [str(rng.choice(drives.KINDS, p=[0.3, 0.3, 0.12, 0.16, 0.12]))] * 2
    kinds.append(str(rng.choice(drives.KINDS)) if rng.random() < 0.4 else kinds[0])
    seconds = float(np.exp(rng.uniform(np.log(20.0), np.log(longest))))
    warm = (10.0, 40.0) if "temperature_fade" in card.hidden else (5.0, 15.0)
    speed = float(np.exp(rng.uniform(*np.log((0.1, 0.4) if plant.family == MAGNETO else (0.2, 1.1)))))
    # Some phenomena need stroke, others speed; a drive that cannot show the hidden effect is drawn again.
    limit = families.tightest(plant)
    highest = float(rng.uniform(0.8, 2.0))
    idle = 0.0 if plant.family == MAGNETO else highest * float(rng.random() < 0.5)
    return [
        (kind, drives.drawn(rng, kind, seconds, speed * rng.uniform(0.85, 1.15), limit, rng.uniform(*warm),
                            highest if current else idle))
        for kind in kinds
    ]  # fmt: skip


def _warmer(rng: np.random.Generator, setting: list[tuple[str, Drive]]) -> list[tuple[str, Drive]]:
    """Recordings that hold one temperature, other than that of the base recording, but for a kelvin or two."""
    hotter = rng.uniform(12.0, 40.0) * rng.choice([-1.0, 1.0], p=[0.3, 0.7])
    return _with_levels(setting, "temperature", 30.0, 30.0 + hotter, 0.05)


def _at_another_current(rng: np.random.Generator, setting: list[tuple[str, Drive]]) -> list[tuple[str, Drive]]:
    """Recordings that hold one current, and a base recording that holds another one."""
    low, high = rng.uniform(0.0, 0.5), rng.uniform(0.8, 2.0)
    ends = (low, high) if rng.random() < 0.7 else (high, low)
    return _with_levels(setting, "current", *ends, 0.0)


def _with_levels(
    setting: list[tuple[str, Drive]], channel: str, base: float, other: float, share: float
) -> list[tuple[str, Drive]]:
    """Drives whose channel keeps a share of its movement about a level: the second one's is that of the base."""
    levels = (other, base, other)
    held = []
    for (kind, drive), level in zip(setting, levels, strict=True):
        values = getattr(drive, channel)
        held.append((kind, replace(drive, **{channel: level + share * (values - values.mean())})))
    return held


def _with_slow_channels(card: Card, rng: np.random.Generator, chain: Chain, drive: Drive, current: bool) -> Chain:
    hot = "temperature_fade" in card.hidden
    thermometer = bool(rng.random() < (0.85 if hot else 0.5))
    moving = drive.current.std() > 0.0
    return replace(
        chain,
        thermometer=thermometer,
        decoy_warming=thermometer and not hot and bool(rng.random() < 0.5),
        ammeter=bool(current or rng.random() < (0.5 if moving else 0.2)),
    )


def _hidden(card, rng, plant, chain, drive, scene) -> tuple[Switched, ...] | None:
    """The calibrated hidden effects; None if they do not show."""
    if not card.hidden:
        return ()
    wanted = LEVELS.get(card.level, MEDIUM)
    first = _one(card.hidden[0], rng, plant, chain, drive, scene, wanted)
    if first is None or len(card.hidden) == 1:
        return None if first is None else (first,)
    late = 1.0 if card.against else 0.0
    second = _one(card.hidden[1], rng, *first.on, drive, scene, wanted, late)
    if second is None:
        return None
    return _together(first, second, drive, wanted, card.against)


def _one(name, rng, plant, chain, drive, scene, wanted, sign: float = 0.0) -> Switched | None:
    if name in FAULTS:
        return in_chain(
            name, int(rng.integers(0, 3)), sign or float(rng.choice([-1.0, 1.0])), plant, chain, drive, wanted
        )
    forms = IN_THE_DAMPER[name](plant, scene, rng)
    if not forms:
        return None
    return in_damper(name, forms[rng.integers(0, len(forms))], chain, drive, wanted)


def _together(first: Switched, second: Switched, drive: Drive, wanted: float, against: bool):
    """Both effects with one base without either; None if they change the same parts, or one hides the other."""
    moved = {key: value for key, value in first.off[0]._asdict().items() if value != getattr(first.on[0], key)}
    turned = {key for key, value in second.off[0]._asdict().items() if value != getattr(second.on[0], key)}
    if turned & set(moved):
        return None
    # Further changes for the second effect (a charge, a bleed) are in the base as well.
    without_first = second.on[0]._replace(**moved), second.on[1]
    both = shown(*second.on, drive)
    if share(shown(*without_first, drive), both) < LEAST_SHOWN * wanted:
        return None
    base = second.off[0]._replace(**moved), first.off[1]
    apart = share(shown(*base, drive), both)
    if against and apart > 1.1 * max(first.strength, second.strength):
        return None
    if not against and apart < 0.5 * wanted:
        return None
    return replace(first, off=base), replace(second, off=base)


def _recorded(card, rng, setting, effects, off, on, attempt) -> Case | None:
    (fit_kind, fit), (_, base), (unseen_kind, unseen) = setting
    forces = {"base": force_of(off[0], base), "fit": force_of(on[0], fit), "unseen": force_of(on[0], unseen)}
    forces["twin"] = force_of(off[0], unseen) if effects else forces["unseen"]
    strength = 0.0
    if effects:
        one, other = (measurement_chain.gauge(chain, unseen, force) for chain, force in
                      ((off[1], forces["twin"]), (on[1], forces["unseen"])))  # fmt: skip
        strength = rms(in_band(other - one)) / float(in_band(forces["unseen"]).std())
        wanted = LEVELS.get(card.level, MEDIUM)
        if not LEAST_SHOWN * (0.6 if card.against else 1.0) <= strength / wanted <= MOST_SHOWN:
            return None
    noise = int(rng.integers(1 << 31))
    recordings = {
        "base": sampled("base", off[1], base, forces["base"], np.random.default_rng([noise, 0])),
        "fit": sampled("fit", on[1], fit, forces["fit"], np.random.default_rng([noise, 1])),
        "unseen": sampled("unseen", on[1], unseen, forces["unseen"], np.random.default_rng([noise, 2])),
        "twin": sampled("twin", off[1], unseen, forces["twin"], np.random.default_rng([noise, 2])),
    }
    skew = late_by(on[1]) if "channel_skew" in card.hidden else 0.0
    return Case(
        card, FAMILIES[on[0].family], (fit_kind, unseen_kind), float(fit.time[-1]), effects, strength, on[1],
        **recordings, skew=skew, attempts=attempt,
    )  # fmt: skip
