"""Does a planned test determine a model's parameters as well as predicted, and better than a random road?

    python benchmarks/bench_parameters.py --cases 20 --seed 3

Dampers, drives and sensors are drawn at random (benchmarks/population). A model is identified on one recording, one
minute on a servo-hydraulic rig is planned for its parameters and simulated, and likewise a random road. The standard
errors are those of a fit to both recordings.
"""

import argparse
from collections.abc import Sequence
from itertools import islice
from typing import Any

import numpy as np
from bench_plan import share
from population.cases import deck
from population.sharpened import record

WITHIN = 1.3
DETERMINED = 0.5
"""Of its value: a parameter with a larger standard error counts as undetermined."""


def report(records: Sequence[dict[str, Any]], seed: int) -> str:
    """The result, as Markdown."""
    rows = [row for one in records for row in one["parameters"]]
    keys = ("before", "predicted", "planned", "road")
    values = {key: np.array([row[key] for row in rows]) for key in keys}
    most = DETERMINED * np.abs([row["value"] for row in rows])
    known = np.all([(values[key] > 0.0) & (values[key] < most) for key in keys], axis=0)
    before, predicted, planned, road = (values[key][known] for key in keys)
    achieved = planned / predicted
    close = int(np.count_nonzero((achieved <= WITHIN) & (achieved >= 1.0 / WITHIN)))
    low, middle, high = np.quantile(achieved, [0.1, 0.5, 0.9])
    return "\n".join([
        f"Seed {seed}: {len(records)} models, {before.size} of {len(rows)} parameters are determined.", "",
        "| standard error | median |", "|---|---|",
        f"| with the test over that without | {np.median(planned / before):.2f} |",
        f"| with a random road over that without | {np.median(road / before):.2f} |",
        f"| with the test over that with the road | {np.median(planned / road):.2f} |",
        f"| achieved over predicted (10 and 90 %) | {middle:.2f} ({low:.2f}, {high:.2f}) |", "",
        f"Achieved within 30 % of the prediction: {share(close, before.size)}.",
    ])  # fmt: skip


def main() -> None:
    """Runs the cases and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=20, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    records = []
    for card in islice((card for card in deck(arguments.seed, False) if card.kind == "hidden"), arguments.cases):
        try:
            records.append(record(card, arguments.seed))
        except Exception as fault:  # a broken case is shown, and must not end the run
            print(f"{card.name}: FAILED {type(fault).__name__}: {fault}", flush=True)
            continue
        found = records[-1]
        ratios = [row["planned"] / row["predicted"] for row in found["parameters"]]
        print(
            f"{found['name']} ({found['family']}, {found['model']}): achieved over predicted "
            f"{np.nanmedian(ratios):.2f} over {len(ratios)} parameters; {found['all_seconds']:.0f} s",
            flush=True,
        )
    print(report(records, arguments.seed))


if __name__ == "__main__":
    main()
