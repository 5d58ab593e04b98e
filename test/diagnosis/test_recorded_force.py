"""The motion behind a compliance, by which a source that is missing there is found."""

from dataclasses import replace

import numpy as np
import pytest
from faults import changed, halves
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.diagnosis import diagnose
from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.diagnosis.recorded_force import rows_with_force
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model.element import new_element
from damper_estimator.signals.layout import X


def sprung(model, name, **values):
    """The model with a compliance around it, and the compliance."""
    element = new_element(find_effect(name), model.effects, values)
    return replace(model.with_missing(element), fit=model.fit), element


def deflections(model, measurement):
    """(n,) m, displacement less that behind the compliances, and N, the force that is looked up."""
    (rows, *_) = data_of(model, [measurement], [measurement]).fit
    (frozen,) = rows_with_force(model, [rows], model.springs)
    before, behind = (one.measurement.kinematics.block[X] for one in (rows, frozen))
    return before - behind, rows.measurement.in_band(rows.measurement.force)


@given(stiffness=st.floats(3e5, 1e8))
def test_a_linear_spring_deflects_by_force_over_stiffness(stiffness, user_model, base):
    model, _ = sprung(user_model, "oil_spring", stiffness_rebound=stiffness, stiffness_compression=stiffness)
    deflection, force = deflections(model, base)
    assert deflection == pytest.approx(force / stiffness, abs=1e-3 * np.abs(force).max() / stiffness)


@given(stiffness=st.floats(1e6, 1e8), share=st.floats(0.2, 0.8))
def test_a_pocket_that_gives_way_moves_nothing_far(stiffness, share, user_model, base):
    """The measured force exceeds what a pocket of gas can ever carry: that force is not behind it."""
    limit = share * float(np.abs(base.force).max())
    limits = {"limit_rebound": limit, "limit_compression": limit}
    model, _ = sprung(user_model, "gas_pocket", stiffness=stiffness, **limits)
    deflection, _ = deflections(model, base)
    assert np.abs(deflection).max() < 4.0 * limit / stiffness


def test_a_stop_is_found_in_a_model_with_a_pocket_of_gas(user_model, base):
    """It acts with far more force than the pocket carries, and only now and then."""
    force = float(np.std(base.force))
    limits = {"limit_rebound": 3.0 * force, "limit_compression": 3.0 * force}
    model, _ = sprung(user_model, "gas_pocket", stiffness=3e7, **limits)
    touched = float(np.quantile(base.kinematics.displacement, 0.985))

    def extra(k):
        own = model.force(k.block) - base.force
        return own + 8.0 * force * np.maximum(k.displacement - touched, 0.0) / (k.displacement.max() - touched)

    fit, unseen = halves(changed(base, extra))
    found = diagnose(model, [fit], [unseen])
    first = found.findings[0]
    assert "end_stop" in {first.phenomenon, *first.tied_with}
    assert first.rmse_after_n < 0.5 * first.rmse_before_n
