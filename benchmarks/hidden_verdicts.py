"""The evaluation of a diagnosis by the hidden-effect bench: one record per case, and the figures over all cases.

A record is one line of the results file, plain numbers and words, so that an interrupted run can continue.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import nan
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from time import perf_counter
from typing import Any

import numpy as np
from hidden_cases import error

from damper_estimator.recordings import open_bag
from damper_estimator.signals import DamperSignals, measure

SKEW_MARGIN = 3e-4  # s


def judged(case: dict[str, Any]) -> dict[str, Any]:
    """The record of a case: findings, result of `improve`, and both compared with the truth.

    With a hidden effect `improve` runs, which begins with the diagnosis of the given model; with none, and in the
    series of skews, only `diagnose`.
    """
    from damper_estimator.diagnosis import diagnose, improve  # not needed to create cases

    data = case["model"], [case["fit"]], [case["unseen"]]
    began = perf_counter()
    if case["kind"] in ("hidden", "pair"):
        improvement = improve(*data)
        seconds = {"improve_seconds": perf_counter() - began}
        diagnosis = improvement.first
        steps = [[step.action, step.effect, step.phenomenon] for step in improvement.steps]
        more = {"improve_verdict": improvement.verdict, "steps": steps, **_errors(case, improvement)}
    else:
        diagnosis = diagnose(*data)
        seconds = {"diagnose_seconds": perf_counter() - began}
        more = {}
    return {
        **{name: case[name] for name in ("name", "kind", "damper", "excitation", "unseen_excitation", "wanted")},
        **{name: case[name] for name in ("strengths", "floor", "force_rms")},
        "phenomena": list(case["phenomena"]),  # as read from JSON
        **seconds,
        "verdict": diagnosis.verdict,
        "findings": [_finding_record(finding) for finding in diagnosis.findings],
        "moved": [moved.name for moved in diagnosis.moved],
        "engine_floor": diagnosis.noise_floor_n,
        "before": error(case["model"], case["unseen"], zero_free=False),
        "base": error(case["model"], case["twin"], zero_free=False),
        "skew": _skew(diagnosis.signals) - _skew(case["signals"].dampers[case["damper"]]),
        "true_skew": _true_skew(case),
        **more,
        "memory_mb": getrusage(RUSAGE_SELF).ru_maxrss / 1024.0,
    }


def _finding_record(finding: Any) -> dict[str, Any]:
    names = ("phenomenon", "effect", "gain", "low", "confidence")
    return {name: getattr(finding, name) for name in names} | {"tied_with": list(finding.tied_with)}


def _skew(signals: DamperSignals) -> float:
    """Delay of the force, s."""
    return signals.force.skew - signals.displacement.skew


def _true_skew(case: dict[str, Any]) -> float:
    hidden = [one["magnitude"] for one in case["calibrations"] if one["phenomenon"] == "channel_skew"]
    return 1e-3 * hidden[0] if hidden else 0.0


def _errors(case: dict[str, Any], improvement: Any) -> dict[str, float]:
    """RMS errors in N of the improved model on the unseen recording, read again through the corrected signal map.

    ``after`` is as `compare` prints it (as are ``before``, and ``base``: the user's model on the same drive without the
    hidden effect); ``left`` is without the gauge's zero and its drift, as ``floor``.
    """
    corrected = replace(case["signals"], dampers={case["damper"]: improvement.signals})
    with open_bag(Path(case["bags"]["unseen"])) as bag:
        unseen = measure(bag, corrected, case["damper"])
    return {"after": error(improvement.model, unseen, zero_free=False), "left": error(improvement.model, unseen)}


def first_named(record: dict[str, Any]) -> str:
    """The phenomenon of the first finding; the verdict without findings."""
    return record["findings"][0]["phenomenon"] if record["findings"] else record["verdict"]


def groups(record: dict[str, Any]) -> list[set[str]]:
    """The tied group of every finding."""
    return [{one["phenomenon"], *one["tied_with"]} for one in record["findings"]]


def first_group(record: dict[str, Any]) -> set[str]:
    """All phenomena of the first tied group."""
    return next(iter(groups(record)), set())


def removed(record: dict[str, Any]) -> float:
    """Share of the excess squared error that `improve` removed; NaN without excess."""
    excess = record["before"] ** 2 - record["base"] ** 2
    return (record["before"] ** 2 - record["after"] ** 2) / excess if excess > 0.0 else nan


def multiple(record: dict[str, Any]) -> float:
    """Remaining error over the noise floor."""
    return record["left"] / record["floor"]


def both_found(named: Sequence[set[str]], hidden: Sequence[str]) -> bool:
    """Whether two phenomena are named by two different findings; ``named`` is the tied group of each finding."""
    first, second = hidden
    return any(
        first in one and second in other for i, one in enumerate(named) for j, other in enumerate(named) if i != j
    )


def improved_by(record: dict[str, Any]) -> list[set[str]]:
    """Effects that `improve` added or corrected, one set per step, without those that it removed again."""
    pruned = {effect for action, effect, _ in record["steps"] if action == "prune"}
    return [{what} for action, effect, what in record["steps"] if action in ("add", "correct") and effect not in pruned]


def skew_recovered(record: dict[str, Any]) -> bool:
    """Whether the skew was named, without ties, and is right."""
    return first_group(record) == {"channel_skew"} and abs(record["skew"] - record["true_skew"]) <= SKEW_MARGIN


def share(values: Sequence[bool]) -> str:
    """``34 of 36 (94 %)``."""
    return f"{sum(values)} of {len(values)} ({100.0 * sum(values) / len(values):.0f} %)" if values else "none"


def median(values: Sequence[float]) -> float:
    """Median of the finite values, NaN without any."""
    finite = [value for value in values if np.isfinite(value)]
    return float(np.median(finite)) if finite else nan


def line(record: dict[str, Any]) -> str:
    """A case in one line."""
    if "failed" in record:
        return f"{record['name']}: FAILED {record['failed']}"
    named = "; ".join(
        one["phenomenon"] + (f" (or {', '.join(one['tied_with'])})" if one["tied_with"] else "")
        for one in record["findings"]
    )
    heading = f"{record['name']}: {record['verdict']} {named}".rstrip()
    if "steps" not in record:
        skew = f", {1e3 * record['skew']:+.2f} ms" if record["kind"] == "skew" else ""
        return f"{heading}{skew} | {record['diagnose_seconds']:.0f} s"
    steps = ", ".join(f"{action} {what or ''}".rstrip() for action, _, what in record["steps"][1:]) or "no step"
    fall = f"{record['before']:.1f} -> {record['after']:.1f} N (base {record['base']:.1f}, floor {record['floor']:.1f})"
    return f"{heading} | {steps} | {fall} | {record['improve_seconds']:.0f} s"
