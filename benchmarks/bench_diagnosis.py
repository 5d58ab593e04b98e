"""Does `diagnose` name the effect hidden in unknown dampers, and does `improve` correct the model?

    python benchmarks/bench_diagnosis.py                       # 150 new cases; continues an interrupted run
    python benchmarks/bench_diagnosis.py --seed 7              # the cases of another run again
    python benchmarks/bench_diagnosis.py --seed 7 --again      # judge them again with the saved recordings and models
    python benchmarks/bench_diagnosis.py --seed 7 8            # several runs in one set of tables
    python benchmarks/bench_diagnosis.py --only friction --cases 10 --no-improve
    python benchmarks/bench_diagnosis.py --given DIR           # cases from elsewhere (population/given_cases.py)

Dampers, effects, drives, sensors and users' models are drawn at random (benchmarks/population). Every case runs in a
separate process and is one line in OUT/SEED/results.jsonl; without ``--seed`` an interrupted run continues, and a new
one draws a new seed. FULL=1 runs 600 cases.
"""

import argparse
import os
import secrets
from itertools import islice
from pathlib import Path
from typing import Any

from page_tables import write_tables
from population import given_cases
from population.case_processes import Order, done, results
from population.cases import PHENOMENA, Card, deck
from population.real_cases import there
from population.result_tables import line, report

OUT = Path("out/population")
CASES, FULL_CASES = 150, 600
LIMIT = 600.0  # s of processor time per case


def chosen(seed: int, arguments: argparse.Namespace) -> list[Card]:
    """The first selected cards, of those from elsewhere or of the deck."""
    wanted = set(arguments.only)

    def fits(card: Card) -> bool:
        by_kind = card.kind in arguments.kind
        return by_kind and (not wanted or bool(wanted & set(card.hidden)))

    every = given_cases.cards(arguments.given) if arguments.given else deck(seed, there())
    return list(islice((card for card in every if fits(card)), arguments.cases))


def seeds_of(arguments: argparse.Namespace) -> list[int]:
    """The given seeds, that of an interrupted run, or a new one."""
    unfinished = arguments.out / "unfinished.txt"
    if arguments.seed:
        return arguments.seed
    if unfinished.exists():
        return [int(unfinished.read_text())]
    return [secrets.randbelow(1_000_000)]


def run(seed: int, arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """The records of all selected cases of a seed; those that are missing are judged."""
    folder = arguments.out / str(seed)
    folder.mkdir(parents=True, exist_ok=True)
    (arguments.out / "unfinished.txt").write_text(str(seed))
    place = folder / "results.jsonl"
    cards = chosen(seed, arguments)
    print(f"seed {seed}: {len(cards)} cases in {folder}", flush=True)
    known = {} if arguments.again else done(place)
    records = {card.name: known[card.name] for card in cards if card.name in known}
    order = Order(seed, folder / "cases", not arguments.no_improve, arguments.limit, arguments.given)
    for record in results([card for card in cards if card.name not in records], order, arguments.workers, place):
        records[record["name"]] = record
        print(f"{len(records)}/{len(cards)} {line(record)}", flush=True)
    (arguments.out / "unfinished.txt").unlink(missing_ok=True)
    return [records[card.name] for card in cards]


def main() -> None:
    """Runs the remaining cases and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    full = os.environ.get("FULL", "") not in ("", "0")
    parser.add_argument("--cases", type=int, default=FULL_CASES if full else CASES, metavar="N", help="of each seed")
    parser.add_argument("--seed", type=int, nargs="+", metavar="N")
    parser.add_argument("--given", type=Path, metavar="DIR", help="judge the cases of a folder instead of drawn ones")
    parser.add_argument("--only", nargs="+", choices=PHENOMENA, default=[], metavar="PHENOMENON")
    parser.add_argument("--kind", nargs="+", choices=("hidden", "nothing", "pair", "real"),
                        default=("hidden", "nothing", "pair", "real"))  # fmt: skip
    parser.add_argument("--no-improve", action="store_true", help="only diagnose")
    parser.add_argument("--again", action="store_true", help="judge all cases again")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N")
    parser.add_argument("--limit", type=float, default=LIMIT, metavar="S", help="processor time of a case")
    parser.add_argument("--out", type=Path, default=OUT, help="folder of cases and results")
    parser.add_argument("-o", "--output", type=Path, metavar="PAGE", help="page to write the tables to")
    arguments = parser.parse_args()
    if not there():
        print("no real recordings (DAMPER_SHARED_DATA): their cases are skipped", flush=True)
    if arguments.given:  # a run of its own, whatever was drawn before
        arguments.out, arguments.seed = arguments.out / f"given_{arguments.given.name}", [0]
    seeds = seeds_of(arguments)
    text = report([record for seed in seeds for record in run(seed, arguments)], seeds)
    (arguments.out / str(seeds[-1]) / "tables.md").write_text(text + "\n")
    print(text)
    if arguments.output:
        write_tables(arguments.output, text)


if __name__ == "__main__":
    main()
