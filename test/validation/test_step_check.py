"""The 50 mm step test, on plant data: a model that was fitted to random motion holds on steps that it never saw."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.identification import fit
from damper_estimator.model import load_model
from damper_estimator.plant import DAMPERS, Sensors, Setup, bench_drive, record
from damper_estimator.recordings import open_bag
from damper_estimator.signals import load_signal_map, measure
from damper_estimator.validation.step_check import step_check
from damper_estimator.workflows import write_record

DAMPER = "passenger_front"
CORRELATION = 0.90  # what the track paper reaches


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """Measurements of a plant damper under an excitation by name."""
    folder = tmp_path_factory.mktemp("step")
    setup = Setup(DAMPERS[DAMPER], Sensors())

    def read(excitation, seconds, seed):
        path = folder / f"{excitation}.mcap"
        write_record(path, {DAMPER: record(setup, bench_drive(excitation, setup.damper, seconds, seed), seed)}, False)
        with open_bag(path) as bag:
            return measure(bag, load_signal_map(None), DAMPER)

    return read


@pytest.fixture(scope="module")
def steps(measured):
    return measured("step", 10.0, 4)


@pytest.fixture(scope="module")
def fitted(measured):
    """The track paper's model, identified on random motion alone."""
    return fit(load_model("carrera_akutain"), [measured("random10", 14.0, 5)]).model


def test_steps_are_found_with_their_height_and_speed(steps, fitted):
    found = step_check(fitted, steps)
    full = [s for s in found if abs(abs(s.height) - 0.050) < 0.003]
    assert len(full) >= 4
    assert {np.sign(s.height) for s in full} == {1.0, -1.0}
    assert all(np.sign(s.peak_velocity) == np.sign(s.height) and 0.4 < abs(s.peak_velocity) < 1.6 for s in full)


def test_the_fitted_track_model_follows_the_plants_steps_in_force_over_displacement(steps, fitted):
    for step in step_check(fitted, steps):
        assert step.measures.correlation > CORRELATION
        assert step.measured.shape == step.modelled.shape == step.displacement.shape
        assert step.measures.nrmse < 0.25


def test_a_wrong_model_is_seen(steps, fitted):
    weak = load_model("linear_viscous")
    good = np.mean([s.measures.rmse_n for s in step_check(fitted, steps)])
    bad = np.mean([s.measures.rmse_n for s in step_check(weak, steps)])
    assert bad > 2.0 * good


def test_a_motion_without_rests_has_no_steps(steps, fitted, measured):
    with pytest.raises(InputError, match="makes no step"):
        step_check(fitted, replace(measured("dyno", 8.0, 6)), least_height=0.06)
