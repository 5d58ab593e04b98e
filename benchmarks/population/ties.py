"""One tie from its card to its record: an undecided diagnosis, a planned test, its simulation and judgement."""

from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

import damper_estimator as de
from damper_estimator.planning import load_rig, plan
from population import cases, drives, families, user_models
from population.case_records import hidden_rms
from population.cases import Card, Case
from population.drives import RATE, Drive
from population.measurement_chain import sampled
from population.simulate import force_of
from population.user_models import DAMPER

MINUTES = 3.0
"""Longest test."""

RIG = "servo_hydraulic"


def record(card: Card, seed: int, folder: Path, random_drives: int) -> dict[str, Any]:
    """One line of the results; ``tie`` is false if the diagnosis has no tie with the hidden effect.

    Args:
        random_drives: number of random drives if the plan finds no separating test.
    """
    began = perf_counter()
    rng = np.random.default_rng([seed, 11, card.number])
    case = cases.made(card, seed, longest=60.0)
    signals = user_models.signal_map(case.chain)
    base, twin, old = (user_models.recording([recording], signals) for recording in (case.base, case.twin, case.fit))
    way = user_models.drawn_way(rng, case.family, False)
    model, how = user_models.made(way, base, twin, user_models.hand_made(base, card.hidden, rng), hidden_rms(case))
    folder.mkdir(parents=True, exist_ok=True)
    de.save_model(model, folder / f"{card.name}.yaml")
    first = de.diagnose(old, model)
    facts = {
        "name": card.name, "hidden": list(card.hidden), "level": card.level, "family": case.family, "model": how,
        "seconds": case.fit.time[-1], "verdict": first.verdict,
        "old": [[one.phenomenon, *one.tied_with] for one in first.findings], "tie": False,
    }  # fmt: skip
    group = facts["old"][0] if first.findings else []
    if len(group) < 2 or card.hidden[0] not in group or len(first.findings) > 1:
        return facts | {"all_seconds": perf_counter() - began}
    plant, _ = case.effects[-1].on
    limit = families.tightest(plant)
    rig = replace(load_rig(RIG), travel=(-limit, limit))
    planned = perf_counter()
    found = plan(model, old.measurements[DAMPER], group, rig, minutes=None, longest=MINUTES)
    facts |= {"tie": True, "plan_seconds": perf_counter() - planned, "minutes": found.minutes}
    chances = {name: (right, wrong) for name, right, wrong in found.chances.by_truth}
    right, wrong = chances[card.hidden[0]]
    facts |= {"right": right, "wrong": wrong, "best": found.chances.best, "would": list(found.would)}
    facts["planned"] = outcome(case, model, signals, played(found, case, rng), rng, "plan")
    count = 1 if found.separates else random_drives
    facts["random"] = [outcome(case, model, signals, road(found, case, rng), rng, "random") for _ in range(count)]
    return facts | {"all_seconds": perf_counter() - began}


def outcome(
    case: Case, model: de.DamperModel, signals: de.SignalMap, drive: Drive, rng: np.random.Generator, name: str
) -> dict[str, Any]:
    """Outcome of a diagnosis of the old and a new recording: right, wrong or tied."""
    plant, chain = case.effects[-1].on
    new = sampled(name, chain, drive, force_of(plant, drive), rng)
    found = de.diagnose(user_models.recording([case.fit, new], signals), model)
    groups = [[one.phenomenon, *one.tied_with] for one in found.findings]
    truth = case.card.hidden[0]
    if groups and groups[0] == [truth]:
        said = "right"
    elif groups and truth not in groups[0] and len(groups[0]) == 1:
        said = "wrong"
    else:
        said = "tied" if groups else "nothing"
    return {"said": said, "groups": groups, "verdict": found.verdict}


def played(found: Any, case: Case, rng: np.random.Generator) -> Drive:
    """The plan's drive at the plant's rate, with the current and warming of an ordinary test."""
    given = np.arange(found.displacement.size) / found.limits.rate
    time = np.arange(round(given[-1] * RATE)) / RATE
    x = CubicSpline(given, found.displacement)(time)
    v = np.gradient(x, 1.0 / RATE)
    return _driven("plan", x, v, case, rng)


def road(found: Any, case: Case, rng: np.random.Generator) -> Drive:
    """A random road as long as the plan, as fast as the old recording, and within the same limits."""
    speed = float(np.quantile(np.abs(np.gradient(case.fit.x, case.fit.time)), 0.99))
    limits = found.limits
    drawn = drives.drawn(rng, "road", 60.0 * found.minutes, speed, limits.high, rng.uniform(5.0, 15.0), 0.0)
    allowed = ((drawn.x, limits.high), (drawn.v, limits.speed), (drawn.a, limits.acceleration))
    factor = 1.0 / max(1.0, *(np.abs(driven).max() / limit for driven, limit in allowed))
    return _driven("road", factor * drawn.x, factor * drawn.v, case, rng)


def _driven(kind: str, x: np.ndarray, v: np.ndarray, case: Case, rng: np.random.Generator) -> Drive:
    current = 0.5 if case.fit.current is None else float(np.median(case.fit.current))
    warm = 30.0 + rng.uniform(5.0, 15.0) * (np.cumsum(np.abs(v)) / max(np.abs(v).sum(), 1e-9) - 0.5)
    return Drive(kind, x, v, np.gradient(v, 1.0 / RATE), np.full(x.size, current), warm)
