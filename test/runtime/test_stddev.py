"""The standard deviation on the line: of the force, or of the residual in an older fit."""

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, make_element
from damper_estimator.runtime import DamperEstimator, deployed

BOTH = {"residual_stddev": 10.0, "force_stddev": 23.0}


def given(fit):
    model = DamperModel("m", "", (make_element(find_effect("linear_viscous")),), fit=fit)
    return DamperEstimator(deployed(model, 60.0, 0.1)).block(np.arange(3) * 1_000_000, np.zeros(3)).stddev[0]


def test_the_stddev_of_the_force_takes_precedence_over_that_of_the_residual():
    assert given(BOTH) == 23.0 and given({"residual_stddev": 10.0}) == 10.0 and np.isnan(given({}))


def test_a_standard_deviation_that_is_no_number_is_refused():
    with pytest.raises(InputError, match="force_stddev = 'much' is not a number"):
        given(BOTH | {"force_stddev": "much"})
