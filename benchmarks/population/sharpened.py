"""One test that sharpens a model's parameters: predicted standard errors against those of a fit with the test."""

from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

import damper_estimator as de
from damper_estimator.planning import load_rig, plan
from population import cases, families, user_models
from population.cases import Card, Case
from population.drives import Drive
from population.measurement_chain import sampled
from population.simulate import force_of
from population.ties import RIG, played, road
from population.user_models import DAMPER

MINUTES = 1.0
MODELS = ("linear_viscous", "viscous_curve", "carrera_akutain", "dahl", "lugre", "bouc_wen")


def record(card: Card, seed: int) -> dict[str, Any]:
    """Per parameter the standard error on the old recording, predicted, with the test, and with a random road."""
    began = perf_counter()
    rng = np.random.default_rng([seed, 13, card.number])
    case = cases.made(card, seed, longest=40.0)
    signals = user_models.signal_map(case.chain)
    old = user_models.recording([case.base], signals)
    name = str(rng.choice(MODELS))
    fitted = de.fit(old, name)
    plant, _ = case.effects[-1].off
    limit = families.tightest(plant)
    rig = replace(load_rig(RIG), travel=(-limit, limit))
    found = plan(fitted.model, old.measurements[DAMPER], (), rig, minutes=MINUTES)
    drives = {"planned": played(found, case, rng), "road": road(found, case, rng, found.minutes)}
    after = {kind: _errors(case, fitted.model, signals, drive, rng) for kind, drive in drives.items()}
    before = {one.name: one.standard_error for one in fitted.parameters}
    rows = [
        {"name": one.address, "value": one.value, "before": before[one.address], "predicted": one.after,
         **{kind: errors.get(one.address, float("nan")) for kind, errors in after.items()}}
        for one in found.parameters if one.address in before
    ]  # fmt: skip
    facts = {"name": card.name, "family": case.family, "model": name, "parameters": rows}
    return facts | {"minutes": found.minutes, "all_seconds": perf_counter() - began}


def _errors(
    case: Case, model: de.DamperModel, signals: de.SignalMap, drive: Drive, rng: np.random.Generator
) -> dict[str, float]:
    """Standard errors by parameter of a fit to the old and the new recording."""
    plant, chain = case.effects[-1].off
    new = sampled("new", chain, drive, force_of(plant, drive), rng)
    return {
        one.name: one.standard_error
        for one in de.fit(user_models.recording([case.base, new], signals), model).parameters
    }
