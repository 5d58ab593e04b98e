"""The hidden-effect bench: does `diagnose` name the effect hidden in a damper, and does `improve` correct the model?

    python benchmarks/bench_hidden.py                        # 120 hidden, 60 nothing, 20 pairs, 20 skews
    FULL=1 python benchmarks/bench_hidden.py                 # all cases of the plant
    python benchmarks/bench_hidden.py --phenomenon friction  # a quick check; also --strength, --kind, --only, --limit

Every case is one line on the screen and one in out/bench_hidden/results.jsonl; a run continues the last one, unless the
code has changed since; ``--fresh`` judges again. Recordings and calibrations are created once and stay in
out/bench_hidden.
"""

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from hashlib import sha256
from multiprocessing import get_context
from pathlib import Path
from shutil import rmtree
from time import perf_counter
from typing import Any

from hidden_cases import made_by, make_case
from hidden_plans import MEDIUM, STRONG, WEAK, Plan, hidden_plans, nothing_plans, pair_plan, pairs, skew_plans
from hidden_tables import report
from hidden_verdicts import judged, line
from page_tables import write_tables

from damper_estimator.plant import PHENOMENA

OUT = Path("out/bench_hidden")
KINDS = ("hidden", "nothing", "pair", "skew")
LEVELS = {"medium": MEDIUM, "weak": WEAK, "strong": STRONG}
JUDGING = ("diagnosis", "effects", "identification", "model", "numerics", "signals", "validation")
NOTHING, PAIRS = 60, 20
AHEAD = 6
"""Plans computed at a time."""


def planning(full: bool, chosen: argparse.Namespace) -> list[Callable[[], list[Plan]]]:
    """The computations of the cases, medium strength first; each takes up to a minute."""
    cache, tasks = OUT / "calibrations", []
    if "hidden" in chosen.kind:
        for wanted in (LEVELS[name] for name in LEVELS if name in chosen.strength):
            for name in chosen.phenomenon:
                tasks.append(partial(hidden_plans, name, wanted, 0 if full else _count(name, wanted), cache))
    if "nothing" in chosen.kind:
        tasks.append(partial(nothing_plans, 4 * NOTHING if full else NOTHING))
    if "skew" in chosen.kind:
        tasks.append(partial(skew_plans, full))
    if "pair" in chosen.kind:
        tasks += [partial(_pair, number, cache) for number in range(len(pairs()))]
    return tasks


def _count(name: str, wanted: float) -> int:
    """Cases of a phenomenon in the balanced bench: 72 medium, 24 weak, 24 strong in all."""
    if wanted == MEDIUM:
        return 4
    number = list(PHENOMENA).index(name)
    return 2 if number % 3 == (0 if wanted == WEAK else 1) else 1


def _pair(number: int, cache: Path) -> list[Plan]:
    plan = pair_plan(number, cache)
    return [plan] if plan else []


def planned(
    pool: ProcessPoolExecutor, tasks: Sequence[Callable[[], list[Plan]]], full: bool, text: str, limit: float
) -> list[Plan]:
    """All cases with ``text`` in their names, up to ``limit``; the balanced bench stops at its number of pairs."""
    found: list[Plan] = []
    for first in range(0, len(tasks), AHEAD):
        waiting = [pool.submit(task) for task in tasks[first : first + AHEAD]]
        found += [plan for future in waiting for plan in future.result() if text in plan.name]
        print(f"{len(found)} cases planned", file=sys.stderr, flush=True)
        if len(found) >= limit or (not full and sum(plan.kind == "pair" for plan in found) >= PAIRS):
            break
    paired = [plan for plan in found if plan.kind == "pair"]
    surplus = set() if full else {plan.name for plan in paired[PAIRS:]}
    return [plan for plan in found if plan.name not in surplus][: int(min(limit, len(found)))]


def run(plan: Plan) -> dict[str, Any]:
    """Creates or loads one case and judges it."""
    try:
        return judged(make_case(plan, OUT))
    except Exception as fault:  # one broken case must not end the run; it is printed and counted
        return {"name": plan.name, "kind": plan.kind, "failed": f"{type(fault).__name__}: {fault}"}


def judged_by() -> str:
    """Fingerprint of the code that determines a verdict."""
    package = Path(__file__).resolve().parents[1] / "damper_estimator"
    sources = [source for folder in JUDGING for source in sorted((package / folder).rglob("*.py"))]
    sources.append(Path(__file__).with_name("hidden_verdicts.py"))
    return sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()[:12]


def kept_results(place: Path, judge: str) -> dict[str, dict[str, Any]]:
    """Records of an earlier run of the same code by name, without those that failed."""
    if not place.exists():
        return {}
    records = (json.loads(text) for text in place.read_text(encoding="utf-8").splitlines() if text.strip())
    return {record["name"]: record for record in records if "failed" not in record and record.get("judged_by") == judge}


def results(pool: ProcessPoolExecutor, plans: Iterable[Plan], place: Path, judge: str) -> Iterator[dict[str, Any]]:
    """Records of cases on completion, written to ``place`` one by one."""
    futures = [pool.submit(run, plan) for plan in plans]
    for future in as_completed(futures):
        record = future.result() | {"judged_by": judge}
        with place.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(record) + "\n")
        yield record


def check_recordings(remake: bool) -> None:
    """Stops if another version of the plant made the saved recordings, or deletes them."""
    mark, fingerprint = OUT / "made_by.txt", made_by()
    if mark.exists() and mark.read_text() != fingerprint:
        if not remake:
            raise SystemExit(f"{OUT}: its recordings are from another plant; --remake creates them again")
        for name in ("cases", "bags", "calibrations"):
            rmtree(OUT / name, ignore_errors=True)
        (OUT / "results.jsonl").unlink(missing_ok=True)
    mark.write_text(fingerprint)


def main() -> None:
    """Runs the remaining cases and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", choices=KINDS, nargs="+", default=KINDS)
    parser.add_argument("--phenomenon", choices=PHENOMENA, nargs="+", default=list(PHENOMENA))
    parser.add_argument("--strength", choices=LEVELS, nargs="+", default=list(LEVELS))
    parser.add_argument("--only", default="", metavar="TEXT", help="only cases with this in their names")
    parser.add_argument("--limit", type=int, default=float("inf"), metavar="N", help="at most so many cases")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="processes (all cores)")
    parser.add_argument("--fresh", action="store_true", help="judge all cases again")
    parser.add_argument("--remake", action="store_true", help="delete recordings of an older plant")
    parser.add_argument("-o", "--output", type=Path, metavar="PAGE", help="page to write the tables to")
    arguments = parser.parse_args()
    full = os.environ.get("FULL", "") not in ("", "0")
    OUT.mkdir(parents=True, exist_ok=True)
    check_recordings(arguments.remake)
    place = OUT / "results.jsonl"
    if len(arguments.phenomenon) < len(PHENOMENA):
        arguments.kind = ["hidden"]
    began = perf_counter()
    with ProcessPoolExecutor(arguments.jobs, mp_context=get_context("spawn")) as pool:
        plans = planned(pool, planning(full, arguments), full, arguments.only, arguments.limit)
        judge = judged_by()
        known = {} if arguments.fresh else kept_results(place, judge)
        records = {plan.name: known[plan.name] for plan in plans if plan.name in known}
        before = len(records)
        for record in results(pool, [plan for plan in plans if plan.name not in records], place, judge):
            records[record["name"]] = record
            print(f"{len(records)}/{len(plans)} {line(record)}", flush=True)
    took = perf_counter() - began
    text = report([records[plan.name] for plan in plans], took, arguments.jobs, len(plans) - before)
    print(text)
    if arguments.output:
        write_tables(arguments.output, text)


if __name__ == "__main__":
    main()
