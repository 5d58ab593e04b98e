"""Contradictions in the JSON of `diagnose` and `improve`: statements that cannot be true at the same time.

The checks read only what a user reads, and share no code with the diagnosis.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

Record = Mapping[str, object]

_SAME = 0.005  # relative difference of a number shown in two places
_FAR = 4.0  # times the noise floor: an error that is far above it ...
_NOTABLE = 0.1  # ... and a notable share of the force cannot be "nothing missing"
_EXPLAINS_NOTHING = 0.05  # of the squared error


def in_diagnosis(record: Record) -> list[str]:
    """Contradictions in one damper of ``diagnose --json``, one sentence each."""
    return [*_verdict(record), *_findings(record), *_reasons(record["rejected"]), *_best(record), *_floor(record)]


def in_improvement(record: Record) -> list[str]:
    """Contradictions in one damper of ``improve --json``, one sentence each."""
    return [*_steps(record), *_reasons(record["rejected"]), *_end(record)]


def between(diagnosis: Record, improvement: Record) -> list[str]:
    """Contradictions between a diagnosis and the improvement of the same model on the same recordings.

    The first findings are promises: the improvement makes the same steps and reaches the same errors.
    """
    if diagnosis["verdict"] != "missing":
        return []
    promised = {finding["effect"]: finding["rmse_after_n"] for finding in diagnosis["findings"]}
    delivered = [step for step in improvement["steps"] if step["action"] in ("add", "correct")][: len(promised)]
    found = []
    if {step["effect"] for step in delivered} != set(promised):
        found.append(f"diagnose proposes {', '.join(promised)}, improve adds {[step['effect'] for step in delivered]}")
    else:
        last = delivered[-1]
        lowest = min(promised.values())
        if not _equal(last["rmse_unseen_n"], lowest):
            found.append(f"promised {lowest:.4g} N with {last['effect']}, delivered {last['rmse_unseen_n']:.4g} N")
    return found


def _verdict(record: Record) -> Iterator[str]:
    verdict, findings = record["verdict"], record["findings"]
    if verdict == "missing" and not findings:
        yield "the verdict is missing, but there is no finding"
    if verdict in ("nothing_missing", "unexplained") and findings:
        yield f"the verdict is {verdict}, but {findings[0]['effect']} is found"
    error, floor, force = record["rmse_n"], record["noise_floor_n"], record["force_rms_n"]
    known = floor is not None and error is not None
    if verdict == "nothing_missing" and known and error > _FAR * floor and error > _NOTABLE * force:
        times = f"{error / floor:.1f} times the floor, {error / force:.0%} of the force"
        yield f"nothing is missing, but {error:.4g} N are left: {times}"


def _findings(record: Record) -> Iterator[str]:
    for finding in record["findings"]:
        name, before, after = (finding[key] for key in ("effect", "rmse_before_n", "rmse_after_n"))
        if not after < before:
            yield f"{name} is found, but the unseen error goes from {before:.4g} to {after:.4g} N"
        if not 0.0 <= finding["confidence"] <= 1.0:
            yield f"{name}: confidence {finding['confidence']}"
        if finding["low"] is not None and not finding["low"] <= finding["gain"] <= finding["high"]:
            yield f"{name}: gain {finding['gain']:.3g} outside of {finding['low']:.3g} to {finding['high']:.3g}"
        if finding["phenomenon"] in finding["tied_with"]:
            yield f"{name} is tied with itself"
        if finding["confidence"] > 0.995 and finding["tied_with"] and after >= before:
            yield f"{name} is certain, tied and explains nothing"


def _reasons(rejected: Sequence[Record]) -> Iterator[str]:
    for row in rejected:
        ways = [way for way in (row.get("kept"), row.get("refitted")) if way]
        if not ways:
            continue
        gains = [way["gain"] for way in ways]
        if row["reason"].startswith("explains nothing") and min(gains) > _EXPLAINS_NOTHING:
            yield f"{row['effect']} explains nothing, but {min(gains):.0%}"
        percent = re.match(r"explains (-?\d+) %.*; (\d+) % required", row["reason"])
        if percent and int(percent[1]) >= int(percent[2]):
            yield f"{row['effect']}: {row['reason']}"
        if re.search(r"-0 %", row["reason"]):
            yield f"{row['effect']}: {row['reason']}"


def _best(record: Record) -> Iterator[str]:
    tried = [row for row in record["rejected"] if row.get("kept") or row.get("refitted")]
    if tried and not record["findings"] and tried[0]["reason"] == "another explains more":
        yield f"nothing is found, but another explains more than {tried[0]['effect']}, the best"


def _floor(record: Record) -> Iterator[str]:
    floor = record["noise_floor_n"]
    if floor is None:
        return
    errors = [record["rmse_n"], *(finding["rmse_after_n"] for finding in record["findings"])]
    if floor > min(errors) * (1.0 + _SAME):
        yield f"the noise floor of {floor:.4g} N is above an error of {min(errors):.4g} N"


def _steps(record: Record) -> Iterator[str]:
    steps = record["steps"]
    for before, after in pairwise(steps):
        if after["action"] in ("add", "correct") and not after["rmse_unseen_n"] < before["rmse_unseen_n"]:
            # A pair is added in two steps: the second must lower the error below the one before both.
            later = steps[steps.index(after) + 1 :]
            if not (later and later[0]["action"] == "add" and later[0]["rmse_unseen_n"] < before["rmse_unseen_n"]):
                yield (
                    f"adding {after['effect']} raises the unseen error from {before['rmse_unseen_n']:.4g} to "
                    f"{after['rmse_unseen_n']:.4g} N"
                )
    if steps[-1]["rmse_unseen_n"] > steps[0]["rmse_unseen_n"] * (1.0 + _SAME):
        yield f"the unseen error rises from {steps[0]['rmse_unseen_n']:.4g} to {steps[-1]['rmse_unseen_n']:.4g} N"
    if not record["sentence"]:
        yield "improve does not say why it stops"


def _end(record: Record) -> Iterator[str]:
    floor, left = record["noise_floor_n"], record["steps"][-1]["rmse_unseen_n"]
    if floor is not None and floor > left * (1.0 + _SAME):
        yield f"the noise floor of {floor:.4g} N is above the last error, {left:.4g} N"
    shown = re.search(r"falls from ([\d.e+]+) to ([\d.e+]+) N", record["sentence"])
    if shown and not float(shown[2]) < float(shown[1]):
        yield f"{shown[0]!r}"


def _equal(one: float, other: float) -> bool:
    return abs(one - other) <= _SAME * max(abs(one), abs(other))
