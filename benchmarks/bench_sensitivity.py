"""How much do names depend on the thresholds of the ranking?

    python benchmarks/bench_diagnosis.py --seed 7 --no-improve     # makes and saves cases
    python benchmarks/bench_sensitivity.py --seed 7 --cases 40     # every threshold at -30 and +30 % on these cases

Each saved case is searched once; then its first round is ranked again with one threshold changed. Thresholds that act
before the ranking or after it are not among them. Prints a table; ``-o`` writes it to a page.
"""

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from bench_diagnosis import OUT
from page_tables import write_tables
from population import saved_cases, user_models
from population.result_tables import table
from population.user_models import DAMPER

from damper_estimator.diagnosis.apply_finding import identified_first
from damper_estimator.diagnosis.diagnose import begun
from damper_estimator.diagnosis.outcome import first_search
from damper_estimator.diagnosis.ranking import Round
from damper_estimator.diagnosis.thresholds import limits, using

RANKING = (
    "gain", "least_force", "penalty", "at_bound", "general_margin", "general_share", "form_free", "sharpness",
    "form_right", "form_share", "own_part", "own_found", "named", "tied",
)  # fmt: skip
CHANGES = (0.7, 1.0, 1.3)


def rounds(folder: Path, names: list[str]) -> Iterator[tuple[str, Round]]:
    """The hidden phenomenon of every saved case, and the first round of its diagnosis."""
    for name in names:
        kept = saved_cases.saved(folder, name)
        signals = user_models.signal_map(kept.chain)
        fit, unseen = (
            user_models.recording(kept.recordings[role], signals).measurements[DAMPER] for role in ("fit", "unseen")
        )
        state = identified_first(begun(kept.model, fit, unseen), "both")
        found, _ = first_search(state, "both")
        if not found.set_aside:
            yield kept.facts["hidden"][0], found.first
            print(f"{name}: searched", flush=True)


def outcome(truth: str, ranked: Round) -> tuple[bool, bool, bool]:
    """Whether the truth is first, whether it is in the first group, and whether the first is named at all."""
    again = replace(ranked)  # without what it has computed before
    best = again.best
    if best is None:
        return False, False, False
    named = not again.reason_against(best, again.baseline.data.force_rms)
    return best.phenomenon == truth, truth in (best.phenomenon, *again.tied(best)), named


def outcomes(truth: str, ranked: Round) -> np.ndarray:
    """(thresholds, changes, 3) bool, see ``outcome``; the middle change is none."""
    found = np.zeros((len(RANKING), len(CHANGES), 3), bool)
    for i, name in enumerate(RANKING):
        for k, factor in enumerate(CHANGES):
            with using(**{name: factor * getattr(limits(), name)}):
                found[i, k] = outcome(truth, ranked)
    return found


def main() -> None:
    """Searches the cases and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True, help="of a run of bench_diagnosis.py")
    parser.add_argument("--cases", type=int, default=40, metavar="N")
    parser.add_argument("--out", type=Path, default=OUT, help="folder of cases and results")
    parser.add_argument("-o", "--output", type=Path, metavar="PAGE", help="page to write the table to")
    arguments = parser.parse_args()
    folder = arguments.out / str(arguments.seed) / "cases"
    facts = {path.stem: json.loads(path.read_text())["facts"] for path in sorted(folder.glob("*.json"))}
    hidden = [name for name, one in facts.items() if one["kind"] == "hidden" and one["level"] != "weak"]
    found = np.array([outcomes(*one) for one in rounds(folder, hidden[: arguments.cases])])
    cells = [[" / ".join(str(count) for count in found[:, i, k].sum(axis=0)) for k in range(len(CHANGES))]
             for i in range(len(RANKING))]  # fmt: skip
    rows = [["threshold", "value", "at -30 %", "as it is", "at +30 %"]]
    rows += [[name, f"{getattr(limits(), name):g}", *row] for name, row in zip(RANKING, cells, strict=True)]
    count = f"{len(found)} medium and strong cases of seed {arguments.seed}"
    text = f"{count}: hidden effect first / in the first group / anything named.\n\n{table(rows)}"
    print(text)
    if arguments.output:
        write_tables(arguments.output, text, "sensitivity")


if __name__ == "__main__":
    main()
