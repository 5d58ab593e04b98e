"""One case from its card to its record: recordings, the user's model, the product's results compared with the truth."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from time import perf_counter, process_time
from typing import Any

import numpy as np

import damper_estimator as de
from damper_estimator.diagnosis.diagnosis_data import data_of, dynamic_force, error_of
from damper_estimator.diagnosis.misfit import error_then, motion_factor
from damper_estimator.model import DamperModel
from population import ablated_models, cases, given_cases, real_cases, saved_cases, user_models
from population.cases import Card, Case
from population.measurement_chain import Samples
from population.user_models import DAMPER


def record(card: Card, seed: int, folder: Path, improving: bool, given: Path | None) -> dict[str, Any]:
    """One line of the results.

    Args:
        folder: of recordings and models that were drawn or read before.
        given: folder of cases from elsewhere; None for drawn ones.
    """
    kept = saved_cases.saved(folder, card.name)
    if kept is None:
        kept = prepared(card, seed) if given is None else given_cases.prepared(given, card)
        saved_cases.save(folder, card.name, kept)
    return kept.facts | judged(kept, improving) | {"all_cpu": process_time()}


def prepared(card: Card, seed: int) -> saved_cases.Kept:
    """The case of a card with its user's model."""
    return _real(card, seed) if card.kind == "real" else _simulated(card, seed)


def _simulated(card: Card, seed: int) -> saved_cases.Kept:
    began = perf_counter()
    case = cases.made(card, seed)
    simulated = perf_counter()
    rng = np.random.default_rng([seed, 3, card.number])
    signals = user_models.signal_map(case.chain)
    recordings = {role: (getattr(case, role),) for role in saved_cases.RECORDINGS}
    base, twin = (user_models.recording(recordings[role], signals) for role in ("base", "twin"))
    moving = case.family == "magneto" and case.base.current is not None and np.ptp(case.base.current) > 0.1
    way = user_models.drawn_way(rng, case.family, bool(moving and "current" not in card.hidden))
    if card.kind == "nothing" and way[0] == "fit":  # effects that a rough model lacks are really missing
        way = ("fit", "hand_made") if rng.random() < 0.4 else ("improve", str(rng.choice(user_models.IMPROVED)))
    model, how = user_models.made(way, base, twin, user_models.hand_made(base, card.hidden, rng), hidden_rms(case))
    facts = _facts(card) | {
        "family": case.family,
        "drive": list(case.drive),
        "seconds": round(case.seconds, 1),
        "rate": case.chain.rate,
        "coil_over": case.chain.spring > 0.0,
        "forms": [effect.form for effect in case.effects],
        "sizes": [effect.size for effect in case.effects],
        "strengths": [effect.strength for effect in case.effects],
        "shown": case.shown,
        "true_skew": case.skew,
        "model": how,
        "attempts": case.attempts,
        "simulate_seconds": simulated - began,
        "model_seconds": perf_counter() - simulated,
    }
    return saved_cases.Kept(facts, case.chain, recordings, model)


def _facts(card: Card) -> dict[str, Any]:
    names = ("name", "number", "kind", "level", "against")
    return {name: getattr(card, name) for name in names} | {"hidden": list(card.hidden)}


def _real(card: Card, seed: int) -> saved_cases.Kept:
    began = perf_counter()
    case = real_cases.made(card, seed)
    simulated = perf_counter()
    signals = user_models.signal_map(case.chain)
    base, twin = (user_models.recording(case.recordings[role], signals) for role in ("base", "twin"))
    ranking = ablated_models.ranked(base, twin)
    model, facts = ranking[0][1], _facts(card) | {"hidden": list(case.hidden)}
    how, form = f"fit {model.name}", case.form
    if card.hidden == ("ablation",):
        less = ablated_models.ablated(ranking, base, twin, np.random.default_rng([seed, 5, card.number]))
        model, how, form = less.model, f"fit {less.model.name} without {less.effect}", "ablation"
        facts |= {"hidden": [less.phenomenon], "whole": less.error}
    facts |= {
        "family": case.setting,
        "drive": ["real", "real"],
        "seconds": round(sum(float(np.ptp(samples.time)) for samples in case.recordings["fit"]), 1),
        "rate": case.chain.rate,
        "coil_over": False,
        "forms": [form] if form else [],
        "sizes": [case.size],
        "strengths": [case.strength],
        "shown": case.shown,
        "true_skew": case.skew,
        "model": how,
        "attempts": 0,
        "simulate_seconds": simulated - began,
        "model_seconds": perf_counter() - simulated,
    }
    return saved_cases.Kept(facts, case.chain, case.recordings, model)


def hidden_rms(case: Case) -> float:
    """N rms, of the hidden effect on the fit recording; with none, of a weak effect."""
    spread = float(case.base.truth.std())
    return spread * max((effect.strength for effect in case.effects), default=0.04)


def judged(kept: saved_cases.Kept, improving: bool) -> dict[str, Any]:
    """The product's results for a case, and the quality of its model.

    ``improve`` begins with a diagnosis, which then counts; two of three cases have no separate one.
    """
    signals = user_models.signal_map(kept.chain)
    recordings = {role: user_models.recording(samples, signals) for role, samples in kept.recordings.items()}
    result: dict[str, Any] = {}
    improving = improving and bool(kept.facts["hidden"])
    if improving:
        better, taken = timed(
            lambda: de.improve(recordings["fit"], kept.model, validate=recordings["unseen"]), "improve"
        )
        result |= taken | _improved(kept, recordings, better)
        diagnosis = better.improvement.first
    if not improving or kept.facts["number"] % 3 == 0:
        found, taken = timed(
            lambda: de.diagnose(recordings["fit"], kept.model, validate=recordings["unseen"]), "diagnose"
        )
        result |= taken
        diagnosis = found.diagnosis
    return result | {
        "verdict": diagnosis.verdict,
        "sentence": diagnosis.sentence,
        "findings": [_finding(one) for one in diagnosis.findings],
        "left": {one.phenomenon: one.left for one in diagnosis.phenomena},
        "moved": [one.name for one in diagnosis.moved],
        "skew": _skew(diagnosis.signals) - _skew(signals.dampers[DAMPER]),
        "found_error": diagnosis.steps[-1][1].rmse_unseen_n if diagnosis.steps else diagnosis.rmse_n,
        "before": user_models.error(kept.model, recordings["unseen"]),
        "base": kept.facts.get("whole") or user_models.error(kept.model, recordings["twin"]),
        "own_base": user_models.error(kept.model, recordings["base"]),
        "force_rms": float(np.concatenate([one.truth for one in kept.recordings["unseen"]]).std()),
        "noise_floor": diagnosis.noise_floor_n,
        "growth": growth(kept.model, recordings["fit"], recordings["unseen"]),
        "memory_mb": getrusage(RUSAGE_SELF).ru_maxrss / 1024.0,
    }


def growth(model: DamperModel, fit: de.Recording, unseen: de.Recording) -> list[float]:
    """Squared error on unseen data over what is expected where nothing has changed: the same share of the force as when
    the model was identified, and the error that is usual on such a motion; NaN where its identification is unknown.
    """
    rows = data_of(model, fit.measurements[DAMPER], unseen.measurements[DAMPER]).unseen
    share = error_of(model, rows) / dynamic_force(rows) / error_then(model)[1]
    return [float(share**2), float((share / motion_factor(model, rows)) ** 2)]


def timed(work: Callable[[], Any], name: str) -> tuple[Any, dict[str, float]]:
    """The result of ``work``, and its wall and processor time in s."""
    began, worked = perf_counter(), process_time()
    given = work()
    return given, {f"{name}_seconds": perf_counter() - began, f"{name}_cpu": process_time() - worked}


def _improved(
    kept: saved_cases.Kept, recordings: Mapping[str, de.Recording], better: de.ImprovementResults
) -> dict[str, Any]:
    unseen = user_models.recording(kept.recordings["unseen"], better.corrected_map())
    return {
        "steps": [[step.action, step.effect, step.phenomenon] for step in better.steps],
        "improve_verdict": better.verdict,
        "after": user_models.error(better.model, unseen),
        "bias": bias(better.model, recordings["unseen"], kept.recordings["unseen"]),
    }


def bias(model: DamperModel, measured: de.Recording, several: Sequence[Samples]) -> float:
    """Mean error in N of the model against the true force, in band, over the judged samples."""
    errors = []
    for measurement, samples in zip(measured.measurements[DAMPER], several, strict=True):
        modelled = measurement.in_band(model.force(measurement.kinematics.block))
        truth = np.interp(measurement.kinematics.time, samples.time - samples.time[0], samples.truth)
        errors.append((modelled - truth)[measurement.judged])
    return float(np.concatenate(errors).mean())


def _finding(one: Any) -> dict[str, Any]:
    names = ("phenomenon", "effect", "confidence", "gain", "low")
    return {name: getattr(one, name) for name in names} | {"tied_with": list(one.tied_with)}


def _skew(signals: Any) -> float:
    return signals.force.skew - signals.displacement.skew
