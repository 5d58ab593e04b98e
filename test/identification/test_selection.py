"""Which parameters a fit may change."""

import pytest

from damper_estimator.errors import InputError
from damper_estimator.identification import free_slots


@pytest.fixture
def model(entry, model_of):
    curve = entry("viscous_curve", velocity=[-1.0, 0.0, 1.0], force=[-900.0, 0.0, 1200.0])
    return model_of(curve, entry("gas_spring"), entry("coulomb"), entry("coulomb"), fixed=("gas_spring.volume",))


def chosen(model, free=(), fix=()):
    return [model.slots[i].address for i in free_slots(model, free, fix)]


CURVE = [f"viscous_curve.force[{i}]" for i in range(3)]
BOTH = ["coulomb.force", "coulomb#2.force"]


@pytest.mark.parametrize(
    ("free", "fix", "expected"),
    [
        ([], [], [*CURVE, "gas_spring.static_force", *BOTH]),
        (["gas_spring.volume"], [], [*CURVE, "gas_spring.static_force", "gas_spring.volume", *BOTH]),
        ([], ["viscous_curve.force[1]"], [CURVE[0], CURVE[2], "gas_spring.static_force", *BOTH]),
        ([], ["viscous_curve.force"], ["gas_spring.static_force", *BOTH]),
        ([], ["viscous_curve", "coulomb#2"], ["gas_spring.static_force", "coulomb.force"]),
        ([], ["coulomb*"], [*CURVE, "gas_spring.static_force"]),
        (["coulomb#?.force"], ["*"], ["coulomb#2.force"]),
        (["volume"], ["*"], ["gas_spring.volume"]),
        (["viscous_curve.force[2]"], ["force"], [CURVE[2], "gas_spring.static_force"]),
    ],
)
def test_the_later_word_wins(model, free, fix, expected):
    assert chosen(model, free, fix) == expected


def test_every_unknown_name_is_reported_with_a_likely_one(model):
    with pytest.raises(InputError, match=r"coulomb\.forse, dahl\*; did you mean coulomb\.force"):
        free_slots(model, ["coulomb.forse"], ["dahl*", "gas_spring"])


def test_a_model_with_all_parameters_fixed_is_refused(model):
    with pytest.raises(InputError, match="--free"):
        free_slots(model, (), ["*"])
