"""Shipped recordings before and after something was hidden, and a user's model identified on the one before."""

from dataclasses import replace

import numpy as np
import pytest
from faults import read

from damper_estimator.diagnosis.baseline import Baseline, baseline_of
from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.identification import fit
from damper_estimator.model import DamperModel, parse_model
from damper_estimator.signals import Measurement


@pytest.fixture(scope="session")
def base() -> Measurement:
    """A damper with stiff oil, before anything is hidden."""
    return read("hidden_base")


@pytest.fixture(scope="session")
def soft() -> tuple[Measurement, Measurement]:
    """The same damper with air in its oil: to fit to, and unseen."""
    return read("hidden_fit"), read("hidden_unseen")


@pytest.fixture(scope="session")
def user_model(base: Measurement) -> DamperModel:
    """A careful user's model of the damper without what is hidden."""
    effects = [{"viscous_curve": {}}, {"gas_spring": {}}, {"dahl": {}}]
    return fit(parse_model({"name": "user", "source": "test", "effects": effects}, "test"), [base], starts=1).model


@pytest.fixture(scope="session")
def noisy(user_model: DamperModel, base: Measurement) -> Baseline:
    """The model with a residual of 100 N rms, white, on both parts; its form plays no part."""
    baseline = baseline_of(user_model, data_of(user_model, [base], [base]), base=())
    random = np.random.default_rng(1)
    fit, unseen = (
        100.0 * random.standard_normal(part.size) for part in (baseline.residual_fit, baseline.residual_unseen)
    )
    rows = {
        part: tuple(one.weighing(np.ones(one.weight.size)) for one in getattr(baseline.data, part))
        for part in ("fit", "unseen")
    }
    return replace(baseline, residual_fit=fit, residual_unseen=unseen, data=replace(baseline.data, **rows))
