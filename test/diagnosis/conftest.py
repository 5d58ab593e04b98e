"""Shipped recordings before and after something was hidden, and a user's model identified on the one before."""

import pytest
from faults import read

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
