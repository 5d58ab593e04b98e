"""Cases from elsewhere: another simulator, or a laboratory that knows what it changed; judged as the drawn ones are.

A case is a file ``NAME.json`` and the recordings ``NAME_base.npz`` (without the hidden effect, on which the user's
model is made), ``NAME_fit.npz``, ``NAME_unseen.npz`` and, if there is one, ``NAME_twin.npz`` (as ``unseen``, without
the effect). Each recording has arrays of length n: ``t`` in s, ``x`` in m and ``force`` in N, both positive in
extension, and perhaps ``current`` in A and ``temperature`` in deg C. The JSON object says ``hidden`` (a list of
phenomena, empty for none), and perhaps ``level`` (weak, medium or strong), ``strength`` (rms of what the effect
changes over rms of the force), ``skew`` (s, of the force, if that is hidden), and in words ``form``, ``damper``,
``drive``.
"""

import json
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from population import saved_cases, user_models
from population.cases import PHENOMENA, Card
from population.measurement_chain import Chain, Samples

_LEAST_STRENGTH = 0.04  # of the force, that a case without a stated strength is taken to have


def cards(folder: Path) -> list[Card]:
    """One for each case of a folder, in order of their names.

    Raises:
        SystemExit: one line; no case, or a phenomenon with an unknown name.
    """
    found = []
    for number, (place, facts) in enumerate(_cases(folder)):
        hidden = tuple(facts["hidden"])
        unknown = ", ".join(set(hidden) - set(PHENOMENA))
        if unknown:
            raise SystemExit(f"{place}: no phenomenon {unknown}; the names are {', '.join(PHENOMENA)}")
        kind = ("nothing", "hidden", "pair")[min(len(hidden), 2)]
        found.append(Card(number, kind, hidden, facts.get("level", "medium") if hidden else "none"))
    return found


def prepared(folder: Path, card: Card) -> saved_cases.Kept:
    """A case with its user's model: by a verb and from a library model drawn at random."""
    place, facts = _cases(folder)[card.number]
    chain = Chain(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    recordings = {role: (_samples(place, role),) for role in saved_cases.RECORDINGS}
    signals = user_models.signal_map(chain)
    base, twin = (user_models.recording(recordings[role], signals) for role in ("base", "twin"))
    rng = np.random.default_rng([0, 3, card.number])
    fit, unseen = (recordings[role][0] for role in ("fit", "unseen"))
    strength, spread = float(facts.get("strength") or _LEAST_STRENGTH), float(unseen.truth.std())
    current = recordings["base"][0].current
    moves = current is not None and float(np.ptp(current)) > 0.1 and "current" not in card.hidden
    way = user_models.drawn_way(rng, "magneto" if fit.current is not None else "", moves)
    if card.kind == "nothing" and way[0] == "fit":  # effects that a rough model lacks are really missing
        way = ("improve", str(rng.choice(user_models.IMPROVED)))
    began = perf_counter()
    hand_made = user_models.hand_made(base, card.hidden, rng)
    model, how = user_models.made(way, base, twin, hand_made, strength * spread)
    return saved_cases.Kept(
        {
            "name": card.name,
            "number": card.number,
            "kind": card.kind,
            "level": card.level,
            "against": False,
            "hidden": list(card.hidden),
            "family": facts.get("damper", "unknown"),
            "drive": [facts.get("drive", "unknown")] * 2,
            "seconds": round(float(np.ptp(fit.time)), 1),
            "rate": float(1.0 / np.median(np.diff(fit.time))),
            "coil_over": False,
            "forms": [facts["form"]] if facts.get("form") else [],
            "sizes": [],
            "strengths": [strength],
            "shown": strength,
            "true_skew": float(facts.get("skew", float("nan"))),
            "model": how,
            "attempts": 0,
            "simulate_seconds": 0.0,
            "model_seconds": perf_counter() - began,
        },
        chain,
        recordings,
        model,
    )


def _cases(folder: Path) -> list[tuple[Path, dict[str, Any]]]:
    found = []
    for place in sorted(folder.glob("*.json")):
        facts = json.loads(place.read_text(encoding="utf-8"))
        if isinstance(facts, dict) and "hidden" in facts:
            found.append((place, facts))
    if not found:
        raise SystemExit(f"{folder}: has no case, a file NAME.json with the phenomena that are 'hidden'")
    return found


def _samples(place: Path, role: str) -> Samples:
    """A recording; without a twin, that without the hidden effect."""
    path = place.with_name(f"{place.stem}_{role}.npz")
    if role == "twin" and not path.exists():
        return _samples(place, "base")
    with np.load(path) as arrays:
        slow = [arrays[name].astype(float) if name in arrays.files else None for name in ("temperature", "current")]
        force = arrays["force"].astype(float)
        return Samples(role, arrays["t"].astype(float), arrays["x"].astype(float), force, *slow, truth=force)
