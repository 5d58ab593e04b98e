"""The live line: samples in, estimates out, the same for one sample as for a record."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, make_element
from damper_estimator.model.estimator import EXTRAPOLATING, GOOD, WARMING_UP, DamperEstimator
from damper_estimator.signals.admission import NON_FINITE

MS = 1_000_000


def entry(name, **values):
    return make_element(find_effect(name), values)


MODEL = DamperModel("m", "", (entry("leak_blow_off_port"), entry("gas_spring"), entry("force_lag")))


def recording(size, seed=0):
    """Stamps with duplicates, steps back, gaps; displacement with NaN now and then."""
    random = np.random.default_rng(seed)
    step = random.choice([2, 2, 2, 3, 0, -5, 150, -400], size, p=[0.4, 0.2, 0.2, 0.1, 0.03, 0.03, 0.02, 0.02]) * MS
    stamp = 1_700_000_000 * 10**9 + np.cumsum(step)
    displacement = 0.02 * np.sin(np.arange(size) * 0.05)
    displacement[random.random(size) < 0.02] = np.nan
    return stamp, displacement


def same(a, b):
    return all(np.array_equal(x, y, equal_nan=True) for x, y in zip(a.values(), b.values(), strict=True))


@given(st.integers(0, 200), st.lists(st.integers(1, 60), min_size=1, max_size=8))
@settings(max_examples=25, deadline=None)
def test_blocks_of_any_size_give_the_same_bits(seed, splits):
    stamp, displacement = recording(240, seed)
    whole = DamperEstimator(MODEL, 60.0, 0.1).block(stamp, displacement)
    live, first, parts = DamperEstimator(MODEL, 60.0, 0.1), 0, []
    for size in [*splits, *([1] * 240)]:
        if first < 240:
            parts.append(live.block(stamp[first : first + size], displacement[first : first + size]))
            first += size
    joined = {key: np.concatenate([p.fields()[key] for p in parts]) for key in whole.fields()}
    assert same(whole.fields(), joined)
    assert np.array_equal(whole.verdict, np.concatenate([p.verdict for p in parts]))


def test_warms_up_after_every_reset():
    stamp = (np.concatenate([np.arange(150), np.arange(150) + 250]) * 2 * MS).astype(np.int64)
    status = DamperEstimator(MODEL, 60.0, 0.1).block(stamp, np.zeros(300)).status
    assert (status[:100] == WARMING_UP).all() and (status[100:150] == GOOD).all()
    assert (status[150:250] == WARMING_UP).all() and (status[250:] == GOOD).all()


def test_outside_the_region_of_the_fit_it_extrapolates():
    model = DamperModel(
        "m", "", (entry("linear_viscous"),), fit={"region": {"displacement": [-0.01, 0.01]}, "residual_stddev": 12.0}
    )
    stamp = np.arange(300) * 2 * MS
    estimates = DamperEstimator(model, 60.0, 0.1).block(stamp, np.where(stamp > 500 * MS, 0.05, 0.0))
    assert estimates.status[120] == GOOD and estimates.status[-1] == EXTRAPOLATING
    assert (estimates.stddev == 12.0).all()


def test_a_force_that_is_not_finite_is_never_good():
    model = DamperModel("m", "", (entry("command_lag"), entry("linear_viscous"), entry("coulomb")))
    stamp = np.arange(300) * 2 * MS
    estimates = DamperEstimator(model, 60.0, 0.1).block(stamp, np.sin(stamp * 1e-9))
    assert np.isfinite(estimates.force[estimates.status == GOOD]).all()


def test_absurd_displacement_is_dropped_and_leaves_no_trace():
    stamp = np.arange(300) * 2 * MS
    clean = DamperEstimator(MODEL, 60.0, 0.1).block(np.delete(stamp, 200), np.zeros(299))
    hit = DamperEstimator(MODEL, 60.0, 0.1).block(stamp, np.where(stamp == 400 * MS, 1e306, 0.0))
    assert hit.verdict[200] == NON_FINITE
    assert same(clean.fields(), hit.fields())


def test_models_with_effects_of_the_measurement_chain_are_refused():
    with pytest.raises(InputError, match="force_offset"):
        DamperEstimator(DamperModel("m", "", (entry("linear_viscous"), entry("force_offset"))), 60.0, 0.1)
