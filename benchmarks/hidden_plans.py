"""The cases of the hidden-effect bench: hidden effect, damper, strength and excitation.

A recording must excite its hidden effect: the magnitude is such that the phenomenon changes the force of the fit
recording by the wanted share; if that is unreachable, or hardly shows on the unseen recording, another damper or
excitation is used. All seeds are fixed.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from itertools import combinations
from pathlib import Path
from zlib import crc32

import numpy as np

from damper_estimator.plant import (
    DAMPERS,
    PHENOMENA,
    Calibration,
    Drive,
    Sensors,
    Setup,
    calibrate,
    current_steps,
    strength,
    switched,
    without,
)
from damper_estimator.vehicle import drive

SECONDS = 60.0
BENCHED = ("passenger_front", "rally_rear", "light_car")
EXCITATIONS = (  # of base and fit recording, of the unseen one
    ("random", "random"), ("road", "road"), ("dyno", "dyno"), ("slow", "slow"),
    ("random10", "random10"), ("random10", "road"), ("road", "random"), ("dyno", "random"),
)  # fmt: skip
MEDIUM, WEAK, STRONG = 0.10, 0.04, 0.20
TOLERANCE = 0.2
"""Largest relative deviation of the reached strength on the fit recording."""

LEAST_SHOWN = 0.5
"""Least share of the wanted strength on the unseen recording, and of each of two effects with the other, as a gas whose
pressure rises with the stroke prevents cavitation.
"""

SKEWS = (-5.0, -3.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 3.0, 5.0)
"""ms."""

ALIKE = (
    {"channel_skew", "valve_delay", "oil_compressibility", "mount_compliance", "hysteresis"},
    {"gas_spring", "spring_rate_error"},
)
"""Phenomena too similar to be separate findings in one recording."""


@dataclass(frozen=True)
class Plan:
    """One planned case.

    Attributes:
        kind: hidden, nothing, pair or skew.
        calibrations: the hidden phenomena and their magnitudes.
        fit, unseen: excitations; the base recording has that of the fit.
        wanted: strength.
    """

    kind: str
    damper: str
    fit: str
    unseen: str
    wanted: float
    seed: int
    calibrations: tuple[Calibration, ...] = ()
    unseen_strength: float = 0.0

    @property
    def phenomena(self) -> tuple[str, ...]:
        """Names of the hidden phenomena."""
        return tuple(item.phenomenon for item in self.calibrations)

    @property
    def name(self) -> str:
        """Unique name."""
        what = "+".join(self.phenomena) or "nothing"
        how = f"{self.calibrations[0].magnitude:+g}ms" if self.kind == "skew" else f"{100 * self.wanted:.0f}"
        return f"{self.kind}-{what}-{how}-{self.damper}-{self.fit}-{self.unseen}-{self.seed}"

    @property
    def setup(self) -> Setup:
        """Damper and sensors with all phenomena at their ordinary magnitude."""
        springy = "spring_rate_error" in self.phenomena and self.seed % 2
        return Setup(DAMPERS[self.damper], Sensors(spring_rate=25000.0, preload=-2500.0) if springy else Sensors())

    @property
    def with_current(self) -> bool:
        """Whether a coil current is recorded: if it acts, and in half of the cases where it does not."""
        return "current" in self.phenomena or self.seed % 2 == 0

    def drives(self) -> tuple[Drive, Drive, Drive]:
        """Of base, fit and unseen recording."""
        calm = without(self.setup, self.phenomena).damper
        names = (self.fit, self.fit, self.unseen)
        return tuple(self._drive(name, calm, 3 * self.seed + number) for number, name in enumerate(names))

    def _drive(self, name: str, damper, seed: int) -> Drive:
        motion = drive(name, damper, SECONDS, seed)
        # The current is added afterwards: a damper that follows it would move differently on a road.
        return replace(motion, current=current_steps(SECONDS, seed)) if self.with_current else motion


def calibrated(plan: Plan, names: tuple[str, ...], cache: Path) -> Plan | None:
    """The plan with the hidden effect at the wanted strength; None if its recordings do not show it."""
    target = replace(plan, calibrations=tuple(Calibration(name, 0.0, 0.0) for name in names))
    place = cache / f"{target.name}.json"
    if place.exists():
        kept = json.loads(place.read_text())
    else:
        kept = _measured(target, names)
        cache.mkdir(parents=True, exist_ok=True)
        place.write_text(json.dumps(kept))
    done = replace(
        plan, calibrations=tuple(Calibration(**item) for item in kept["items"]), unseen_strength=kept["unseen"]
    )
    reached = all(abs(item.strength / plan.wanted - 1.0) <= TOLERANCE for item in done.calibrations)
    return done if reached and min(kept["unseen"], kept["together"]) >= LEAST_SHOWN * plan.wanted else None


def _measured(plan: Plan, names: tuple[str, ...]) -> dict[str, object]:
    setup, drives = plan.setup, plan.drives()
    sign = -1.0 if plan.seed % 3 == 0 else 1.0
    items = []
    for name in names:
        others = without(setup, tuple(other for other in names if other != name))
        items.append(calibrate(name, others, drives[1], plan.wanted, sign))
        if abs(items[-1].strength / plan.wanted - 1.0) > TOLERANCE:
            break
    off, on = switched(setup, tuple(items))
    together = min(strength(_all_but(setup, items, item), on, drives[1]) for item in items)
    return {"items": [asdict(item) for item in items], "unseen": strength(off, on, drives[2]), "together": together}


def _all_but(setup: Setup, items: list[Calibration], less: Calibration) -> Setup:
    for item in items:
        phenomenon = PHENOMENA[item.phenomenon]
        setup = (phenomenon.off if item is less else phenomenon.on)(setup, item.magnitude)
    return setup


def _combinations(first: int) -> Iterator[tuple[str, tuple[str, str]]]:
    """Every damper with every excitation once, dissimilar ones in sequence, from a varying start."""
    count = len(EXCITATIONS) * len(BENCHED)
    for number in range(first, first + count):  # 3 and 8 have no common factor: all 24 pairs occur
        yield BENCHED[number % len(BENCHED)], EXCITATIONS[number % len(EXCITATIONS)]


def _seed(*words: object) -> int:
    return crc32(" ".join(map(str, words)).encode()) % 1_000_000


def hidden_plans(phenomenon: str, wanted: float, count: int, cache: Path) -> list[Plan]:
    """The first ``count`` cases whose recordings show a phenomenon; 0 is all."""
    found: list[Plan] = []
    first = 5 * list(PHENOMENA).index(phenomenon) + {MEDIUM: 0, WEAK: 11, STRONG: 18}.get(wanted, 3)
    for damper, (fit, unseen) in _combinations(first):
        plan = Plan("hidden", damper, fit, unseen, wanted, _seed(phenomenon, wanted, damper, fit, unseen))
        ready = calibrated(plan, (phenomenon,), cache)
        found += [ready] if ready else []
        if count and len(found) == count:
            break
    return found


def nothing_plans(count: int) -> list[Plan]:
    """Cases whose fit and unseen recordings are further ones of the base."""
    plans = []
    every = list(_combinations(0))
    for number in range(count):
        damper, (fit, unseen) = every[number % len(every)]
        plans.append(Plan("nothing", damper, fit, unseen, 0.0, _seed("nothing", number)))
    return plans


def pairs() -> list[tuple[str, str]]:
    """Two different phenomena each, in an order drawn once."""
    every = [pair for pair in combinations(PHENOMENA, 2) if not any(set(pair) <= group for group in ALIKE)]
    return [every[i] for i in np.random.default_rng(2).permutation(len(every))]


def pair_plan(number: int, cache: Path) -> Plan | None:
    """The case of one pair; None if no recording shows both."""
    names = pairs()[number]
    for damper, (fit, unseen) in list(_combinations(7 * number))[:6]:
        ready = calibrated(Plan("pair", damper, fit, unseen, MEDIUM, _seed(*names, damper, fit)), names, cache)
        if ready:
            return ready
    return None


def skew_plans(full: bool) -> list[Plan]:
    """The force late or early by known times, on random and road recordings."""
    plans = []
    for number, milliseconds in enumerate(SKEWS):
        for at, excitation in enumerate(("random", "road")):
            for damper in BENCHED if full else (BENCHED[(number + at) % len(BENCHED)],):
                item = Calibration("channel_skew", milliseconds, float("nan"))
                seed = _seed("skew", milliseconds, excitation, damper)
                plans.append(Plan("skew", damper, excitation, excitation, 0.0, seed, (item,)))
    return plans
