"""Rigs: those of the library load, and what cannot be is refused in one line."""

import pytest

from damper_estimator.effects.trial import Ranges
from damper_estimator.errors import InputError
from damper_estimator.planning import library_rigs, limits_of, load_rig, parse_rig

RIG = {
    "name": "mine", "source": "test", "kind": "played", "rate": 1000.0, "displacement": [-0.05, 0.05], "speed": 1.0,
    "acceleration": 100.0, "force": 5000.0, "frequency": [0.1, 20.0],
}  # fmt: skip
DRIVEN = Ranges(compression=-0.02, extension=0.03, speed=0.8, acceleration=50.0, force=500.0, seconds=60.0)


def test_the_librarys_rigs_load():
    assert library_rigs() == ["crank", "four_post", "servo_hydraulic", "track"]
    for name in library_rigs():
        assert load_rig(name).name == name


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"speed": 0.0}, "speed is 0"),
        ({"speed": True}, "give a number"),
        ({"displacement": [0.05, -0.05]}, "the lowest comes first"),
        ({"displacement": 0.05}, "[lowest, highest]"),
        ({"frequency": [0.0, 20.0]}, "begins at 0 Hz"),
        ({"rate": 30.0}, "four samples per period"),
        ({"kind": "magic"}, "none of played, crank, manoeuvres"),
        ({"kind": "crank"}, "needs its amplitude"),
        ({"kind": "manoeuvres"}, "needs manoeuvres"),
        ({"measures": ["force"]}, "must measure displacement and force"),
        ({"stroke": 1.0}, "unknown entry stroke"),
        ({"mean_positions": 3}, "true or false"),
    ],
)
def test_a_rig_that_cannot_be_is_refused(change, said):
    with pytest.raises(InputError, match=said.replace("[", r"\[")) as refused:
        parse_rig(RIG | change, "mine.yaml")
    assert str(refused.value).startswith("mine.yaml: ")


def test_a_rig_without_an_entry_is_refused():
    with pytest.raises(InputError, match="has no force"):
        parse_rig({key: value for key, value in RIG.items() if key != "force"}, "mine.yaml")


def test_an_unknown_name_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match="did you mean crank"):
        load_rig("crnk")


def test_the_recordings_limit_the_stroke_unless_the_travel_is_stated():
    bounds = limits_of(parse_rig(RIG, "rig"), DRIVEN, 30.0)
    assert (bounds.low, bounds.high, bounds.home) == (-0.02, 0.03, 0.0)
    stated = limits_of(parse_rig(RIG | {"travel": [-0.04, 0.06]}, "rig"), DRIVEN, 30.0)
    assert (stated.low, stated.high) == (-0.04, 0.05)


def test_limits_that_leave_nothing_are_refused():
    with pytest.raises(InputError, match="leave no stroke"):
        limits_of(parse_rig(RIG | {"travel": [0.06, 0.08]}, "rig"), DRIVEN, 30.0)
    with pytest.raises(InputError, match="raise the band"):
        limits_of(parse_rig(RIG | {"frequency": [15.0, 20.0]}, "rig"), DRIVEN, 10.0)
    with pytest.raises(InputError, match="set a shorter crank"):
        limits_of(parse_rig(RIG | {"kind": "crank", "amplitude": 0.04}, "rig"), DRIVEN, 30.0)
