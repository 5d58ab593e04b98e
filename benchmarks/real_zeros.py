"""By how much the mean error of one damper differs between real recordings, with nothing changed in the damper.

    python benchmarks/real_zeros.py [--model dahl]

The model is fitted to the first recordings of each setting of ``real_data``; of its mean error on the others that on
the fitted ones is subtracted, and the rest is printed as a share of the force.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
from real_data import LABCONTROL, UTFSM, Setting, import_all, read

from damper_estimator.diagnosis.misfit import mean_error
from damper_estimator.identification import fit
from damper_estimator.model import load_model


def shares(folder: Path, setting: Setting, name: str) -> np.ndarray:
    """(unseen recordings,) difference of the mean error, share of the force about its mean."""
    fitted, unseen = read(folder, setting.fitted), read(folder, setting.unseen)
    model = fit(load_model(name), fitted).model
    before = np.mean([mean_error(model, m) for m in fitted])
    return np.array([(mean_error(model, m) - before) / np.std(m.force[m.judged]) for m in unseen])


def main() -> None:
    """Prints one line per setting, and how many are larger than a finding must be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", default="dahl", help="library model")
    arguments = parser.parse_args()
    found = []
    with tempfile.TemporaryDirectory() as folder:
        import_all(Path(folder))
        for setting in (*UTFSM, *LABCONTROL):
            found.append(shares(Path(folder), setting, arguments.model))
            print(f"{setting.name:>7}  " + "  ".join(f"{100.0 * share:+5.1f} %" for share in found[-1]), flush=True)
    sizes = np.abs(np.concatenate(found))
    parts = ", ".join(f"{np.mean(sizes > least):.0%} above {100.0 * least:g} %" for least in (0.015, 0.03))
    print(f"{sizes.size} recordings: median {100.0 * np.median(sizes):.1f} % of the force, {parts}")


if __name__ == "__main__":
    main()
