"""Means of the error: the gauge's zero, or a force of the damper at rest."""

from dataclasses import replace

import numpy as np
import pytest
from faults import changed, halves

from damper_estimator.diagnosis import diagnose, with_misfit
from damper_estimator.diagnosis.thresholds import using
from damper_estimator.identification import fit as identify
from damper_estimator.model import load_model
from damper_estimator.signals import Kinematics, Measurement
from damper_estimator.signals.layout import TEMPERATURE


@pytest.fixture(scope="module")
def plain(base):
    """A user's model without gas."""
    return identify(load_model("viscous_curve"), [base], starts=1).model


def charge(newtons: float, column: float, exponent: float = 1.2):
    """Gas force between slow and fast, of a charge that changes by ``newtons`` in a column of ``column`` m."""
    return lambda k: -newtons * (1.0 + k.displacement / column) ** -exponent


@pytest.mark.parametrize("newtons", [80.0, -80.0])
def test_a_mean_that_a_changed_charge_may_make_is_tied_with_the_gauges_zero(newtons, plain, base):
    """A gas column so long that the force on the rod hardly changes over the stroke, with more gas or with less."""
    fit, unseen = halves(changed(base, charge(newtons, 0.6)))
    first = diagnose(plain, [fit], [unseen]).findings[0]
    assert {"force_offset", "gas_spring"} <= {first.phenomenon, *first.tied_with}


@pytest.mark.parametrize("newtons", [150.0, -150.0])
def test_a_mean_with_the_spring_of_a_short_gas_column_is_the_gas(newtons, plain, base):
    fit, unseen = halves(changed(base, charge(newtons, 0.12)))
    found = diagnose(plain, [fit], [unseen])
    assert found.findings[0].phenomenon == "gas_spring"
    assert "force_offset" not in {name for one in found.findings for name in (one.phenomenon, *one.tied_with)}
    assert found.findings[0].rmse_after_n < 0.5 * found.findings[0].rmse_before_n


def test_lost_gas_is_found_in_a_model_that_has_gas(user_model, base):
    fit, unseen = halves(changed(base, charge(-150.0, 0.12)))
    found = diagnose(user_model, [fit], [unseen])
    assert found.findings[0].phenomenon == "gas_spring"


def test_a_small_mean_is_no_finding_on_other_recordings(user_model, base):
    """The mean error of an unchanged damper differs by 1 to 2 % of the force between recordings of real rigs."""
    force = float(base.force.std())

    def names(share: float) -> set[str]:
        fit, unseen = halves(replace(changed(base, lambda k: share * force), recording="other.mcap"))
        return {one.phenomenon for one in diagnose(user_model, [fit], [unseen]).findings}

    assert not names(0.02) and not names(-0.02)
    assert names(0.05) == {"force_offset"} == names(-0.05)


@pytest.mark.parametrize("newtons, warmth", [(-80.0, "warmer"), (80.0, "colder")])
def test_a_mean_may_be_gas_whose_temperature_nobody_measured(newtons, warmth, user_model, base):
    shifted = replace(changed(base, lambda k: newtons), recording="other.mcap")
    for is_measured in (False, True):
        celsius = 25.0 if is_measured else np.nan
        fit, unseen = halves(replace(shifted, kinematics=with_temperature(base, celsius)))
        first = diagnose(user_model, [fit], [unseen]).findings[0]
        assert first.phenomenon == "force_offset"
        assert (f"gas that is {warmth}" in first.remark) == (not is_measured)


def with_temperature(measurement: Measurement, celsius: float) -> Kinematics:
    """The motion with a constant temperature, deg C; NaN where none was measured."""
    block = measurement.kinematics.block.copy()
    block[TEMPERATURE] = celsius
    return replace(measurement.kinematics, block=block)


@pytest.mark.parametrize("share", [-0.6, 0.5])
def test_a_zero_that_has_changed_makes_nothing_else_new(share, base):
    """A straight line for a digressive damper errs by a quarter of the force, as it always has."""
    count = len(base.kinematics) // 6
    first, *others = (base.part(k * count, (k + 1) * count) for k in range(3))
    rough = with_misfit(identify(load_model("linear_viscous"), [first], starts=1).model, [first])

    def found(offset: float) -> list[set[str]]:
        fit, unseen = (replace(changed(m, lambda k: offset), recording="other.mcap") for m in others)
        return [{one.phenomenon, *one.tied_with} for one in diagnose(rough, [fit], [unseen]).findings]

    with using(usual=0.9, growth=6.0):
        assert not found(0.0)
        (zero,) = found(share * float(base.force.std()))
    assert "force_offset" in zero
