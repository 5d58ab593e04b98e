"""The live line: samples in, estimates out, the same for one sample as for a record."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect
from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, make_element
from damper_estimator.model.element import Element
from damper_estimator.runtime import DEGRADED, EXTRAPOLATING, GOOD, WARMING_UP, DamperEstimator, deployed
from damper_estimator.signals.admission import NON_FINITE
from damper_estimator.signals.layout import TEMPERATURE, V

MS = 1_000_000


def entry(name, **values):
    return make_element(find_effect(name), values)


FIT = {"residual_stddev": 12.0, "region": {"velocity": [-9.0, 9.0]}}
MODEL = DamperModel("m", "", (entry("leak_blow_off_port"), entry("gas_spring"), entry("force_lag")), fit=FIT)


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
    whole = DamperEstimator(deployed(MODEL, 60.0, 0.1)).block(stamp, displacement)
    live, first, parts = DamperEstimator(deployed(MODEL, 60.0, 0.1)), 0, []
    for size in [*splits, *([1] * 240)]:
        if first < 240:
            parts.append(live.block(stamp[first : first + size], displacement[first : first + size]))
            first += size
    joined = {key: np.concatenate([p.fields()[key] for p in parts]) for key in whole.fields()}
    assert same(whole.fields(), joined)
    assert np.array_equal(whole.verdict, np.concatenate([p.verdict for p in parts]))


def test_warms_up_after_every_reset():
    stamp = (np.concatenate([np.arange(150), np.arange(150) + 250]) * 2 * MS).astype(np.int64)
    status = DamperEstimator(deployed(MODEL, 60.0, 0.1)).block(stamp, np.zeros(300)).status
    assert (status[:100] == WARMING_UP).all() and (status[100:150] == GOOD).all()
    assert (status[150:250] == WARMING_UP).all() and (status[250:] == GOOD).all()


def test_outside_the_region_of_the_fit_it_extrapolates():
    model = DamperModel(
        "m", "", (entry("linear_viscous"),), fit={"region": {"displacement": [-0.01, 0.01]}, "residual_stddev": 12.0}
    )
    stamp = np.arange(300) * 2 * MS
    estimates = DamperEstimator(deployed(model, 60.0, 0.1)).block(stamp, np.clip((stamp / 1e9 - 0.4) * 0.5, 0.0, 0.05))
    assert estimates.status[120] == GOOD and estimates.status[-1] == EXTRAPOLATING
    assert (estimates.stddev == 12.0).all()


def test_a_force_that_is_not_finite_is_never_good():
    model = DamperModel("m", "", (entry("command_lag"), entry("linear_viscous"), entry("coulomb")))
    stamp = np.arange(300) * 2 * MS
    estimates = DamperEstimator(deployed(model, 60.0, 0.1)).block(stamp, np.sin(stamp * 1e-9))
    assert np.isfinite(estimates.force[estimates.status == GOOD]).all()


@compiled
def lost_when_hot(parameters, settings, kinematics, state, force):
    for i in range(force.size):
        force[i] += np.nan if kinematics[TEMPERATURE, i] > 100.0 else kinematics[V, i]


@pytest.mark.parametrize("heat", [(0, 150), (500, 600)])
def test_published_forces_are_finite_and_degraded_if_the_model_has_no_finite_force(heat):
    """The last force is held, none before the first; the model and its state restart afterwards."""
    effect = Effect(kernel=lost_when_hot, kind="source", name="lost_when_hot")
    model = DamperModel("m", "", (Element(effect, {}, {}), entry("linear_viscous")), fit=FIT)
    stamp = np.arange(500) * 2 * MS
    temperature = np.where((stamp >= heat[0] * MS) & (stamp < heat[1] * MS), 200.0, 20.0)
    estimates = DamperEstimator(deployed(model, 60.0, 0.1)).block(
        stamp, 0.01 * np.sin(stamp * 1e-8), temperature=temperature
    )
    lost = np.isnan(estimates.force)
    assert np.array_equal(lost, temperature > 100.0) and (estimates.status[lost] == DEGRADED).all()
    first = int(np.argmax(lost))
    assert (estimates.published[lost] == (estimates.force[first - 1] if first else 0.0)).all()
    assert np.array_equal(estimates.published[~lost], estimates.force[~lost])
    assert (estimates.status[stamp >= (heat[1] + 200) * MS] == GOOD).all()


def test_without_the_command_that_it_was_fitted_with_it_extrapolates():
    model = DamperModel("m", "", (entry("semi_active_squash"),), fit=FIT | {"region": {"command": [0.0, 2.0]}})
    stamp = np.arange(300) * 2 * MS
    command = np.where(stamp < 400 * MS, np.nan, 1.0)
    status = DamperEstimator(deployed(model, 60.0, 0.1)).block(stamp, np.zeros(300), command).status
    assert (status[100:200] == EXTRAPOLATING).all() and (status[200:] == GOOD).all()


def test_absurd_displacement_is_dropped_and_only_counted():
    stamp = np.arange(300) * 2 * MS
    clean = DamperEstimator(deployed(MODEL, 60.0, 0.1)).block(np.delete(stamp, 200), np.zeros(299))
    hit = DamperEstimator(deployed(MODEL, 60.0, 0.1)).block(stamp, np.where(stamp == 400 * MS, 1e306, 0.0))
    assert hit.verdict[200] == NON_FINITE
    assert same(clean.fields() | {"status": 0}, hit.fields() | {"status": 0})
    assert (hit.status[200:298] == DEGRADED).all() and (clean.status[200:] == GOOD).all()


@pytest.mark.parametrize(
    "fit", [{"residual_stddev": "much"}, {"region": [1]}, {"region": {"velocity": [1.0]}}, {"region": {"velocity": 3}}]
)
def test_the_fit_of_a_model_must_consist_of_numbers(fit):
    with pytest.raises(InputError, match=next(iter(fit))):
        DamperEstimator(deployed(DamperModel("m", "", (entry("linear_viscous"),), fit=fit), 60.0, 0.1))


def test_models_with_effects_of_the_measurement_chain_are_refused():
    with pytest.raises(InputError, match="force_offset"):
        DamperEstimator(deployed(DamperModel("m", "", (entry("linear_viscous"), entry("force_offset"))), 60.0, 0.1))
