"""Does a planned test break the ties of a diagnosis as often as predicted?

    python benchmarks/bench_plan.py --ties 6                 # until six ties were judged; continues the last run
    python benchmarks/bench_plan.py --seed 7 --ties 60 --workers 2

Dampers, effects, drives, sensors and users' models are drawn at random (benchmarks/population). If a diagnosis of one
recording ends in a tie with the hidden effect, a test is planned on a servo-hydraulic rig, simulated with the effect
and diagnosed together with the old recording, and likewise a random road of the same length. If the plan finds no
separating test within the limits, several random roads are tried. Every case runs in a separate process and is one line
in OUT/SEED/results.jsonl.
"""

import argparse
import json
import resource
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import islice, takewhile
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from page_tables import write_tables
from population.cases import Card, deck
from population.scoring import wilson

from damper_estimator.planning import HOPELESS, LIKELY

OUT = Path("out/plan")
BINS = (0.0, HOPELESS, LIKELY, 0.8, 0.95, 1.0001)
Record = dict[str, Any]


def record(card: Card, seed: int, ties: Path, random_drives: int, limit: float) -> Record:
    """The record of one card; a failure is a record as well.

    Args:
        ties: folder of saved ties.
        random_drives: if the plan finds no separating test; below zero nothing is planned.
        limit: s of processor time.
    """
    resource.setrlimit(resource.RLIMIT_CPU, (round(limit), round(limit) + 60))
    from population.ties import Tie, judged, looked_for

    try:
        found = looked_for(card, seed, ties)
        if isinstance(found, Tie):
            return judged(found, seed, random_drives) if random_drives >= 0 else found.facts
        return found
    except Exception as fault:  # a broken case is counted, and must not end the run
        return {"name": card.name, "tie": False, "failed": f"{type(fault).__name__}: {fault}"}


def done(place: Path) -> dict[str, Record]:
    """Records of an earlier run by name."""
    lines = place.read_text(encoding="utf-8").splitlines() if place.exists() else []
    return {record["name"]: record for record in (json.loads(text) for text in lines if text.endswith("}"))}


def share(hits: int, count: int) -> str:
    """Hits of a count, with the 90 % interval."""
    if not count:
        return "-"
    low, high = wilson(hits, count)
    return f"{hits} of {count}: {100.0 * hits / count:.0f} % ({100.0 * low:.0f}-{100.0 * high:.0f})"


def report(records: Sequence[Record], seed: int) -> str:
    """The tables, as Markdown."""
    ties = [record for record in records if record["tie"] and "planned" in record]
    able = [record for record in ties if record["right"] >= LIKELY]
    failed = sum("failed" in record for record in records)
    rows = ["| test | right | wrong | tie stays |", "|---|---|---|---|"]
    said = {"planned": [record["planned"]["said"] for record in able],
            "random road": [one["said"] for record in able for one in record["random"][:1]]}  # fmt: skip
    for name, outcomes in said.items():
        counts = [sum(one in kinds for one in outcomes) for kinds in (("right",), ("wrong",), ("tied", "nothing"))]
        rows.append(f"| {name} | {' | '.join(share(count, len(outcomes)) for count in counts)} |")
    lines = [
        f"Seed {seed}: {len(records)} cases, {len(ties)} ties with the hidden effect, {failed} failed.", "",
        f"Ties in which the plan expects a right decision if the hidden effect is the true one ({len(able)}):", "",
        *rows, "", *reliability(ties), "", inseparable([record for record in ties if record["right"] < HOPELESS]),
    ]  # fmt: skip
    if ties:
        seconds = [record["plan_seconds"] for record in ties]
        lines.append(
            f"A plan took {np.median(seconds):.0f} s of processor time (median), {max(seconds):.0f} s at most."
        )
    return "\n".join(lines)


def reliability(ties: Sequence[Record]) -> list[str]:
    """Predicted and achieved probability: of the hidden effect, and of the plan's sentence, which does not know it."""
    lines = ["| predicted P(right) | mean | achieved |", "|---|---|---|"]
    for words, of in (
        ("if it is the hidden effect", lambda one: one["right"]),
        ("whatever it is", lambda one: one["overall"][0]),
    ):
        for low, high in zip(BINS, BINS[1:], strict=False):
            inside = [one for one in ties if low <= of(one) < high]
            if inside:
                hits = sum(one["planned"]["said"] == "right" for one in inside)
                mean = float(np.mean([of(one) for one in inside]))
                lines.append(
                    f"| {words}, {low:.2f} to {min(high, 1.0):.2f} | {mean:.2f} | {share(hits, len(inside))} |"
                )
        if ties:
            hits = sum(one["planned"]["said"] == "right" for one in ties)
            mean = float(np.mean([of(one) for one in ties]))
            lines.append(f"| {words}, all | {mean:.2f} | {share(hits, len(ties))} |")
    return lines


def inseparable(hopeless: Sequence[Record]) -> str:
    """Whether any drive confirmed an effect that the plan says none can confirm."""
    broken = sum(any(one["said"] == "right" for one in (record["planned"], *record["random"])) for record in hopeless)
    tried = sum(len(record["random"]) for record in hopeless)
    return (
        f"Predicted that no test confirms the hidden effect: {len(hopeless)}; none did (the plan's, {tried} random "
        f"roads): {share(len(hopeless) - broken, len(hopeless))}."
    )


def line(record: Record) -> str:
    """A case in one line."""
    if "failed" in record:
        return f"{record['name']}: FAILED {record['failed']}"
    if not record["tie"]:
        return f"{record['name']}: no tie ({record['old']}), {record['diagnosis_seconds']:.0f} s"
    if "planned" not in record:
        return f"{record['name']} ({record['family']}, {record['model']}): tie {record['old'][0]}"
    random = "/".join(one["said"] for one in record["random"])
    return (
        f"{record['name']} ({record['family']}, {record['model']}): {record['old'][0]}, predicted "
        f"{record['right']:.2f} right {record['wrong']:.3f} wrong in {record['minutes']:.1f} min; "
        f"planned {record['planned']['said']} {record['planned']['groups']}; random {random}; "
        f"plan {record['plan_seconds']:.0f} s, all {record['all_seconds']:.0f} s"
    )


def main() -> None:
    """Runs cases until enough ties were judged, and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ties", type=int, default=60, metavar="N", help="to be judged (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", default=[], metavar="PHENOMENON")
    parser.add_argument("--random-drives", type=int, default=5, metavar="N", help="random roads if no test separates")
    parser.add_argument("--workers", type=int, default=1, metavar="N")
    parser.add_argument("--limit", type=float, default=1800.0, metavar="S", help="processor time of a case")
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--find", action="store_true", help="only look for ties and save them; a later run judges them")
    parser.add_argument(
        "--judge-again", type=Path, metavar="OUT/SEED", help="only the ties that a run with the same seed saved there"
    )
    parser.add_argument("--report", action="store_true", help="only the tables of the existing results")
    parser.add_argument("-o", "--output", type=Path, metavar="PAGE", help="page to write the tables to")
    arguments = parser.parse_args()
    folder = arguments.out / str(arguments.seed)
    folder.mkdir(parents=True, exist_ok=True)
    ties = (arguments.judge_again or folder) / "ties"
    place = folder / ("found.jsonl" if arguments.find else "results.jsonl")
    records = done(place)
    # What an earlier run looked at is not simulated again: its ties are in files, the others have none.
    known = done(folder / "found.jsonl") if not arguments.find else {}
    records = {name: one for name, one in known.items() if not one["tie"]} | records
    cards = (card for card in deck(arguments.seed, False) if card.kind == "hidden")
    cards = (card for card in cards if not arguments.only or card.hidden[0] in arguments.only)
    if arguments.judge_again:
        found = {place.stem for place in ties.glob("*.pickle")}
        last = max((int(name.partition("-")[0]) for name in found), default=-1)
        cards = (card for card in takewhile(lambda card: card.number <= last, cards) if card.name in found)
    left = (card for card in cards if card.name not in records)
    drives = -1 if arguments.find else arguments.random_drives
    context = get_context("spawn")
    while not arguments.report and sum(record["tie"] for record in records.values()) < arguments.ties:
        batch = list(islice(left, arguments.workers))
        if not batch:
            break
        with ProcessPoolExecutor(arguments.workers, mp_context=context) as pool:
            waiting = [pool.submit(record, card, arguments.seed, ties, drives, arguments.limit) for card in batch]
            for one in (future.result() for future in as_completed(waiting)):
                records[one["name"]] = one
                with place.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(one) + "\n")
                print(line(one), flush=True)
    if arguments.find:
        return
    text = report(list(records.values()), arguments.seed)
    print(text)
    if arguments.output:
        write_tables(arguments.output, text)


if __name__ == "__main__":
    main()
