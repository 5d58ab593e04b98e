"""What re-identification says of the parameters that are there."""

import numpy as np
import pytest
from faults import changed

from damper_estimator.cli.main import main
from damper_estimator.diagnosis.baseline import baseline_of, positions_in
from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.diagnosis.local_fit import locally_fitted
from damper_estimator.diagnosis.ranking import round_of
from damper_estimator.diagnosis.reidentify import Reidentified, reidentified
from damper_estimator.identification.knots import with_knots_of, with_placed_knots
from damper_estimator.model import DamperModel, library_models, load_model
from damper_estimator.model.element import labels
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, load_signal_map, measure


def identified_again(model: DamperModel, fit: Measurement, unseen: Measurement) -> Reidentified:
    """What a diagnosis that tries no effect finds of the parameters."""
    data = data_of(model, [fit], [unseen])
    return reidentified(round_of(baseline_of(model, data), [], "both"), data)


@pytest.fixture
def curve() -> DamperModel:
    """A straight line of 1000 N s/m on the knots of the effect itself."""
    model = load_model("viscous_curve")
    (element,) = model.effects
    return model.with_vector([1000.0 * v for v in element.settings["velocity"]])


def test_a_curve_that_loses_knots_is_compared_at_those_it_has_left(curve, base):
    fit, unseen = base.part(3000, 3600), base.part(3600, 4200)
    again = identified_again(curve, fit, unseen)
    assert len(again.model.slots) < len(curve.slots)
    knots = again.model.effects[0].settings["velocity"]
    before = {f"viscous_curve.force[{k}]": 1000.0 * v for k, v in enumerate(knots)}
    assert again.moved
    for moved in again.moved:
        assert moved.before == pytest.approx(before[moved.name])


def test_a_curve_read_off_at_other_knots_is_the_same_curve(curve, base):
    placed = with_placed_knots(curve, [base.part(3000, 3600)])
    read_off = with_knots_of(curve, placed.with_vector(np.zeros(len(placed.slots))))
    assert read_off == placed
    inside = np.abs(base.kinematics.velocity) < min(abs(placed.effects[0].settings["velocity"][k]) for k in (0, -1))
    block = np.ascontiguousarray(base.kinematics.block[:, inside])
    assert read_off.force(block) == pytest.approx(curve.force(block))


def test_forces_of_a_curve_are_compared_with_their_constant(base):
    """The zero of the gauge is free while effects are compared; then no force of the curve is determined."""
    halves = base.part(0, 4000), base.part(4000, 8000)
    model = locally_fitted(with_placed_knots(load_model("viscous_curve"), halves[:1]), halves[:1])
    names = [slot.address for slot in model.slots]
    stiffer = {name: 1.3 * value for name, value in zip(names, [slot.value for slot in model.slots], strict=True)}
    truth = model.with_values(stiffer)
    fit, unseen = (changed(one, lambda k: truth.force(k.block) - model.force(k.block)) for one in halves)
    again = identified_again(model, fit, unseen)
    assert again.enough and len(again.moved) >= 3
    for moved in again.moved:
        assert np.isfinite(moved.standard_error)
        assert moved.after == pytest.approx(
            stiffer[moved.name], abs=0.05 * max(abs(slot.value) for slot in truth.slots)
        )


@pytest.mark.parametrize("name", ["ME2mm5Hz", "ME25mm0x5Hz"])
def test_a_press_is_re_identified_from_a_bare_curve(name, shared_data, tmp_path):
    file = shared_data / "utfsm_mr_damper" / f"{name}.txt.gz"
    assert main(["import", str(file), "--columns", "utfsm_mr_damper", "-o", str(tmp_path)]) == 0
    with open_bag(sorted(tmp_path.glob("*.mcap"))[0]) as bag:
        measured = measure(bag, load_signal_map(None), "mr_damper")
    half = len(measured.kinematics) // 2
    again = identified_again(load_model("viscous_curve"), measured.part(0, half), measured.part(half, 2 * half))
    assert again.gain > 0.5
    assert {moved.name for moved in again.moved} <= {slot.address for slot in again.model.slots}


@pytest.mark.parametrize("name", library_models())
def test_parameters_keep_their_places_when_compliances_are_taken_as_rigid(name):
    """Also those that scale a compliance, and those whose labels change because another entry has gone."""
    model = rigid = load_model(name)
    while series := [label for label, element in labels(rigid.effects) if element.effect.kind == "series"]:
        rigid = rigid.without(series[0])
    places = positions_in(model, rigid)
    assert len(set(places)) == len(rigid.slots)
    assert [model.slots[i].value for i in places] == [slot.value for slot in rigid.slots]
