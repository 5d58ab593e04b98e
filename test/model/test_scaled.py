"""Modifiers that scale a series element: the same physics for all of them, and clear refusals."""

import numpy as np
import pytest
import yaml

from damper_estimator.errors import InputError
from damper_estimator.model import load_model, parse_model
from damper_estimator.model.model_files import model_yaml
from damper_estimator.signals.layout import COMMAND, DT, ROWS, TEMPERATURE, A, T, V, X


def block(command=0.7, seconds=2.0, rate=1000.0):
    time = np.arange(round(seconds * rate)) / rate
    omega = 2.0 * np.pi * 2.0
    found = np.full((ROWS, time.size), np.nan)
    found[T], found[DT] = time, np.diff(time, prepend=0.0)
    found[X], found[V] = 0.02 * np.sin(omega * time), 0.02 * omega * np.cos(omega * time)
    found[A] = -(omega**2) * found[X]
    found[COMMAND], found[TEMPERATURE] = command, 40.0
    return found


def model(*scaled, damping=2e4):
    first = [{"scaled": list(scaled)}] if scaled else []
    path = [*first, {"tanh_hysteresis": {"force": 400.0}}, {"viscous": {"rate": 1500.0}}]
    return parse_model({"name": "m", "effects": [{"dashpot": {"damping": damping, "path": path}}]}, "m")


GAIN = {"command_gain": {"rest": 0.25, "bend": 0.0, "reference": 1.0}}


def test_a_scaled_dashpot_is_a_dashpot_of_that_rate():
    scale = 0.25 + 0.75 * 0.7
    assert model(GAIN).force(block()) == pytest.approx(model(damping=2e4 * scale).force(block()), abs=1e-5)


def test_scales_multiply():
    both = model(GAIN, {"viscosity_gain": {"rate": 0.02, "reference": 30.0}})
    scale = (0.25 + 0.75 * 0.7) * np.exp(-0.2)
    assert both.force(block()) == pytest.approx(model(damping=2e4 * scale).force(block()), abs=1e-5)


def test_position_is_that_of_the_damper_and_not_the_deflection():
    """Without motion at a position: a scale over the position acts, although the deflection is almost zero."""
    there = model({"position_gain": {"gain": 1.0, "middle": 0.1, "scale": 0.1}})
    motion = block()
    expected = 1.0 + ((motion[X] - 0.1) / 0.1) ** 2
    assert expected.min() > 1.5
    scaled, bare = (np.abs(tested.force(motion))[10:].max() for tested in (there, model()))  # the first sample is stiff
    assert scaled > 1.01 * bare


def test_contributions_still_add_up_and_the_file_gives_the_same_model_back():
    spencer = load_model("spencer")
    parts = spencer.contributions(block())
    assert sum(parts.values()) == pytest.approx(spencer.force(block()), abs=1e-9)
    assert parse_model(yaml.safe_load(model_yaml(spencer)), "again") == spencer


def test_without_the_series_element_its_scale_goes_too():
    assert model(GAIN).without("dashpot").uses() == {"tanh_hysteresis", "viscous"}


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        ([{"scaled": [GAIN]}, "viscous"], "must be first in the path of a series effect"),
        ([{"path": ["viscous", {"scaled": [GAIN]}]}], "must be first in the path of a series effect"),
        ([{"dashpot": {"path": ["viscous", {"scaled": [GAIN]}]}}], "must be first in the path of a series effect"),
        ([{"dashpot": {"path": [{"scaled": ["viscous"]}, "viscous"]}}], "only modifiers can scale"),
        ([{"dashpot": {"path": [{"scaled": [GAIN]}]}}], "its path is empty"),
    ],
)
def test_scaled_elsewhere_is_refused(effects, message):
    with pytest.raises(InputError, match=message):
        parse_model({"name": "m", "effects": effects}, "m").force(block())
