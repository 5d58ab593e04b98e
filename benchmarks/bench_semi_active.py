"""Errors of the library's semi-active models on drives that they were not fitted to, with a moving current.

    python benchmarks/bench_semi_active.py [--models NAME ...]

The three simulated dampers of ``ride``, each fitted on one bench and two road recordings of 40 s, and judged on others
of the same kinds (other roads, other steps of the current) and on bumps that are faster than all that was fitted.
"""

import argparse
import tempfile
from pathlib import Path
from time import process_time

from damper_estimator.identification import fit
from damper_estimator.model import load_model
from damper_estimator.signals import Measurement
from damper_estimator.validation.comparison import compare
from damper_estimator.vehicle import CORNER_CASES
from damper_estimator.workflows.ride_training import EXCITATIONS, recorded

MODELS = ("semi_active_yield", "semi_active_gap", "semi_active_oil")
FITTED, UNSEEN = 40.0, 25.0  # s
FIRST_UNSEEN = 101  # seed
BAR = 30.0  # N, on unseen drives as fast as the fitted ones


def drives(name: str, kinds: tuple[str, ...], seconds: float, seed: int, folder: Path) -> list[Measurement]:
    """One recording of each kind."""
    corner = CORNER_CASES[name]
    return [recorded(name, corner, kind, folder, seconds, seed + k) for k, kind in enumerate(kinds)]


def main() -> None:
    """Prints one row per damper and model."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", nargs="+", default=MODELS)
    arguments = parser.parse_args()
    kinds = (*EXCITATIONS, "bump")
    print(f"{'unseen error, N':<34}" + "".join(f"{kind:>10}" for kind in kinds) + "   together   fit     time")
    for name in CORNER_CASES:
        with tempfile.TemporaryDirectory() as folder:
            seen = drives(name, EXCITATIONS, FITTED, 1, Path(folder))
            unseen = drives(name, kinds, UNSEEN, FIRST_UNSEEN, Path(folder))
        for model in arguments.models:
            began = process_time()
            found = fit(load_model(model), seen, seed=1)
            seconds = process_time() - began
            each = [compare(found.model, recording).measures.rmse_n for recording in unseen]
            together = compare(found.model, *unseen[:-1]).measures.rmse_n
            judged = "met" if together < BAR else "missed"
            columns = "".join(f"{error:>10.1f}" for error in each)
            print(f"{name + ', ' + model:<34}{columns}{together:>11.1f}{found.rmse_n:>6.0f} {seconds:>6.0f} s   "
                  f"bar {BAR:.0f} N {judged}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
