"""Ties of diagnoses, saved as they are found; and one tie from its plan to its judgement."""

import pickle
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

import damper_estimator as de
from damper_estimator.planning import HOPELESS, Plan, load_rig, plan
from population import cases, drives, families, user_models
from population.case_records import hidden_rms
from population.cases import Card, Case
from population.drives import RATE, Drive
from population.measurement_chain import sampled
from population.simulate import force_of
from population.user_models import DAMPER

BY_HAND = 0.45
"""Share of users with a hand-made chain, as among all that fit theirs in population.user_models."""

MINUTES = 3.0
"""Longest test."""

LONGEST = 30.0
"""s, of the recordings that leave a tie: short ones leave more of them, and are soon simulated."""

RIG = "servo_hydraulic"


@dataclass(frozen=True)
class Tie:
    """A diagnosis of one recording that ended undecided.

    Attributes:
        facts: for its record.
        group: tied phenomena, one of them the hidden effect.
        standing: by phenomenon that the diagnosis tried, its share of the error and its probability.
    """

    facts: dict[str, Any]
    case: Case
    model: de.DamperModel
    group: tuple[str, ...]
    standing: dict[str, tuple[float, float]]

    @property
    def signals(self) -> de.SignalMap:
        """The user's."""
        return user_models.signal_map(self.case.chain)


def looked_for(card: Card, seed: int, folder: Path) -> Tie | dict[str, Any]:
    """The tie of a card, saved in a folder; the record of the diagnosis if it has no tie with the hidden effect."""
    place = folder / f"{card.name}.pickle"
    if place.exists():
        return saved(place)
    began = perf_counter()
    rng = np.random.default_rng([seed, 11, card.number])
    case = cases.made(card, seed, longest=LONGEST)
    model, how = _users_model(rng, case)
    first = de.diagnose(user_models.recording([case.fit], user_models.signal_map(case.chain)), model)
    facts = {
        "name": card.name, "hidden": list(card.hidden), "level": card.level, "family": case.family, "model": how,
        "form": case.effects[-1].form, "seconds": case.fit.time[-1], "verdict": first.verdict,
        "old": [[one.phenomenon, *one.tied_with] for one in first.findings], "tie": False,
        "diagnosis_seconds": perf_counter() - began,
    }  # fmt: skip
    group = tuple(facts["old"][0]) if first.findings else ()
    if len(group) < 2 or card.hidden[0] not in group or len(first.findings) > 1:
        return facts
    standing = {one.phenomenon: (one.left, one.probability) for one in first.only.phenomena}
    found = Tie(facts | {"tie": True}, case, model, group, standing)
    folder.mkdir(parents=True, exist_ok=True)
    partial = place.with_suffix(".part")
    partial.write_bytes(pickle.dumps(found))
    partial.rename(place)
    return found


def _users_model(rng: np.random.Generator, case: Case) -> tuple[de.DamperModel, str]:
    """A model that was fitted to the recording without the effect, and its name; the hand-made chain if another one
    errs too much there. Models that ``improve`` makes are left out because they take minutes.
    """
    signals = user_models.signal_map(case.chain)
    base, twin = (user_models.recording([recording], signals) for recording in (case.base, case.twin))
    names = user_models.FITTED if case.family != "magneto" else (*user_models.FITTED, *user_models.MAGNETIC[1:])
    by_hand = user_models.hand_made(base, case.card.hidden, rng)
    if rng.random() < BY_HAND:
        return de.fit(base, by_hand).model, "fit hand_made"
    name = str(rng.choice(names))
    model = de.fit(base, name).model
    off = [user_models.error(model, one) for one in (base, twin)]
    if max(off) <= user_models.GOOD_ENOUGH * hidden_rms(case):
        return model, f"fit {name}"
    return de.fit(base, by_hand).model, "fit hand_made"


def saved(place: Path) -> Tie:
    """A tie of an earlier run; only of runs on this computer, because the file is a pickle."""
    found = pickle.loads(place.read_bytes())
    assert isinstance(found, Tie)
    return found


def judged(tie: Tie, seed: int, random_drives: int) -> dict[str, Any]:
    """One line of the results: the plan, and how diagnoses with its test and with random roads end.

    Args:
        random_drives: number of random roads if the plan says that no test confirms the hidden effect; none is driven
            after the first that does.
    """
    began, processor, case = perf_counter(), process_time(), tie.case
    truth = case.card.hidden[0]
    plant, _ = case.effects[-1].on
    limit = families.tightest(plant)
    rig = replace(load_rig(RIG), travel=(-limit, limit))
    old = user_models.recording([case.fit], tie.signals)
    probable = {name: probability for name, (_, probability) in tie.standing.items()}
    found = plan(
        tie.model, old.measurements[DAMPER], tie.group, rig, probable=probable, longest=MINUTES, alternatives=False
    )
    chances = found.chances
    assert chances is not None
    predicted = {name: [right, wrong] for name, right, wrong in chances.by_truth}
    right, wrong = predicted.get(truth, (0.0, 0.0))  # a plan leaves out what no simulation shows
    facts: dict[str, Any] = {
        "plan_seconds": process_time() - processor, "minutes": found.minutes, "right": right, "wrong": wrong,
        "best": chances.best, "overall": [chances.right, chances.wrong],
        "predicted": predicted, "probable": {name: probable.get(name) for name in tie.group},
        "effects": list(found.effects),
        "steps": [words for _, words in found.listed],
    }  # fmt: skip
    is_hopeless = right < HOPELESS
    facts["planned"] = outcome(tie, "plan", [seed, 12, case.card.number], found)
    facts["random"] = []
    for number in range(random_drives if is_hopeless else 1):
        entropy = [seed, 13, case.card.number, number]
        facts["random"].append(outcome(tie, "road", entropy, found, MINUTES if is_hopeless else found.minutes))
        if facts["random"][-1]["said"] == "right":
            break
    return tie.facts | facts | {"all_seconds": perf_counter() - began}


def outcome(tie: Tie, kind: str, entropy: Sequence[int], found: Plan, minutes: float = 0.0) -> dict[str, Any]:
    """Outcome of a diagnosis of the old and a new recording, the plan or a road: right, wrong, tied or nothing."""
    rng = np.random.default_rng(entropy)
    drive = road(found, tie.case, rng, minutes) if kind == "road" else played(found, tie.case, rng)
    plant, chain = tie.case.effects[-1].on
    # One spring in both recordings, however far the new one drives it.
    chain = replace(chain, wide=float(np.abs(tie.case.fit.x).max()))
    new = sampled(kind, chain, drive, force_of(plant, drive), rng)
    diagnosis = de.diagnose(user_models.recording([tie.case.fit, new], tie.signals), tie.model)
    groups = [[one.phenomenon, *one.tied_with] for one in diagnosis.findings]
    truth = tie.case.card.hidden[0]
    if groups and groups[0] == [truth]:
        said = "right"
    elif groups and truth not in groups[0] and len(groups[0]) == 1:
        said = "wrong"
    else:
        said = "tied" if groups else "nothing"
    return {"said": said, "groups": groups, "verdict": diagnosis.verdict}


def played(found: Plan, case: Case, rng: np.random.Generator) -> Drive:
    """The plan's drive at the plant's rate, with the current and warming of an ordinary test."""
    given = np.arange(found.displacement.size) / found.limits.rate
    time = np.arange(round(given[-1] * RATE)) / RATE
    x = CubicSpline(given, found.displacement)(time)
    v = np.gradient(x, 1.0 / RATE)
    return _driven("plan", x, v, case, rng)


def road(found: Plan, case: Case, rng: np.random.Generator, minutes: float) -> Drive:
    """A random road, as fast as the old recording, and within the limits of the plan."""
    speed = float(np.quantile(np.abs(np.gradient(case.fit.x, case.fit.time)), 0.99))
    limits = found.limits
    drawn = drives.drawn(rng, "road", 60.0 * minutes, speed, limits.high, rng.uniform(5.0, 15.0), 0.0)
    allowed = ((drawn.x, limits.high), (drawn.v, limits.speed), (drawn.a, limits.acceleration))
    factor = 1.0 / max(1.0, *(np.abs(driven).max() / limit for driven, limit in allowed))
    return _driven("road", factor * drawn.x, factor * drawn.v, case, rng)


def _driven(kind: str, x: np.ndarray, v: np.ndarray, case: Case, rng: np.random.Generator) -> Drive:
    current = 0.5 if case.fit.current is None else float(np.median(case.fit.current))
    warm = 30.0 + rng.uniform(5.0, 15.0) * (np.cumsum(np.abs(v)) / max(np.abs(v).sum(), 1e-9) - 0.5)
    return Drive(kind, x, v, np.gradient(v, 1.0 / RATE), np.full(x.size, current), warm)
