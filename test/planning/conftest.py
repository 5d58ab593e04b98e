"""What the tests of planning share: a damper with gas, driven for some seconds."""

import pytest
from simple_damper import gas, recorded

import damper_estimator as de


@pytest.fixture(scope="session")
def fitted():
    """A model that was identified on the damper alone."""
    return de.fit(recorded(lambda x, v: 0.0, seed=5), "linear_viscous").model


@pytest.fixture(scope="session")
def old():
    """The damper with gas, driven over a small stroke."""
    return recorded(gas, scale=0.12)
