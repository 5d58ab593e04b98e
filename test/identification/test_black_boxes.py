"""Black-box polynomials on a simulated damper, which none of them is: a model never fits worse than one it contains."""

import numpy as np
import pytest

from damper_estimator.identification import fit
from damper_estimator.model import load_model
from damper_estimator.plant import DAMPERS, bench_drive, simulate
from damper_estimator.signals import Counts, Measurement, default_signals
from damper_estimator.signals.kinematics import differentiate_recording

STEP = 1.95e-3  # s, as in the source
SECONDS = 12.0
ROUNDING = 1e-6
# Larger model: those that it contains.
CONTAINS = {
    "black_box_2": ["black_box_1"],
    "black_box_4": ["black_box_3"],
    "black_box_5": ["black_box_3"],
    "black_box_6": ["black_box_3", "black_box_4", "black_box_5"],
}


@pytest.fixture(scope="module", params=list(DAMPERS)[:3])
def errors(request):
    """Error in N by model, each fitted to two levels of random displacement of one damper."""
    damper = DAMPERS[request.param]
    data = [recording(damper, name, seed) for seed, name in enumerate(("random", "random10"), 1)]
    names = sorted({*CONTAINS, *(name for inner in CONTAINS.values() for name in inner)})
    return {name: fit(load_model(name), data).rmse_n for name in names}


def recording(damper, name, seed):
    truth = simulate(damper, bench_drive(name, damper, SECONDS, seed))
    time = np.arange(int(SECONDS / STEP) - 1) * STEP
    x, force = (np.interp(time, truth.time, values) for values in (truth.drive.displacement, truth.force))
    stamp = np.round(time * 1e9).astype(np.int64)
    kinematics, _ = differentiate_recording(stamp, x, 60.0, 0.1)
    counts, signals = Counts(samples=x.size), default_signals("d")
    return Measurement(name, "d", kinematics, force, kinematics.warm(), counts, force, x, 60.0, 30.0, signals)


@pytest.mark.parametrize("larger", CONTAINS)
def test_a_model_never_fits_worse_than_those_it_contains(larger, errors):
    for smaller in CONTAINS[larger]:
        assert errors[larger] <= errors[smaller] * (1.0 + ROUNDING)


def test_the_brackets_gain_something(errors):
    assert errors["black_box_6"] < 0.999 * errors["black_box_3"]
