"""The structure rules reproduce every row of Tables 9 and 10, and lead to models that can be fitted."""

import pytest
import yaml

from damper_estimator.characterization.model_structure import (
    derive,
    passive_structure,
    semi_active_structure,
    structure_model,
)
from damper_estimator.model.model_files import model_yaml, parse_model

TABLE_9 = [
    ((0, 1, 1), "simple"), ((1, 1, 1), "simple"), ((0, 1), "simple"),
    ((0, 1, 2), "inertial_simple"), ((0, 2, 2), "inertial_simple"), ((0, 2, 6), "inertial_simple"),
    ((1, 1, 6), "inertial_simple"), ((0, 1, 3), "stiff_simple"), ((1, 3, 3), "stiff_simple"),
    ((0, 2, 5), "complete"), ((1, 3, 5), "complete"),
]  # fmt: skip
TABLE_10 = [
    ((0, 4, 4), "simple"),
    ((4, 4, 4), "simple"),
    ((0, 4, 6), "complete"),
    ((4, 5, 5), "complete"),
    ((0, 6, 5), "complete"),
]


@pytest.mark.parametrize(("types", "structure"), TABLE_9)
def test_table_9(types, structure):
    assert passive_structure(types) == structure


@pytest.mark.parametrize(("types", "structure"), TABLE_10)
def test_table_10(types, structure):
    assert semi_active_structure(types) == structure


def test_the_papers_case_study_gets_its_structure():
    structure = derive({"low": 3}, {"low": 5}, symmetric=False)
    assert (structure.passive, structure.semi_active, structure.library_name) == (
        "stiff_simple",
        "complete",
        "lozoya_santos_stiff_simple",
    )


@pytest.mark.parametrize("types", [{"low": 1}, {"low": 3}, {"low": 2}, {"low": 5}], ids=str)
@pytest.mark.parametrize("active", [{}, {"low": 4}, {"low": 5}], ids=str)
@pytest.mark.parametrize("symmetric", [True, False])
def test_every_structure_is_a_model_file_with_its_parameters_free(types, active, symmetric):
    model = structure_model(derive(types, active, symmetric))
    assert parse_model_again(model).slots == model.slots
    assert model.fit == {}
    driven = {slot.address for slot in model.slots if slot.address.startswith("semi_active_squash")}
    assert bool(driven) == bool(active)
    fixed = {slot.address.split(".")[1] for slot in model.slots if slot.fixed}
    assert fixed == ({"time_constant"} if active else set()) | ({"stiffness"} if active == {"low": 4} else set())


def parse_model_again(model):
    """The model after a round trip through the text of its file."""
    return parse_model(yaml.safe_load(model_yaml(model)), "again")
