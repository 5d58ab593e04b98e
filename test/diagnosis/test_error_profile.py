"""At which speeds and frequencies a model errs is known from its identification; the same elsewhere is not new."""

from dataclasses import replace

import numpy as np
import pytest

import damper_estimator as de
from damper_estimator.diagnosis import error_profile
from damper_estimator.diagnosis.diagnosis_data import data_of, dynamic_force
from damper_estimator.diagnosis.error_profile import profile_of, recorded_profile
from damper_estimator.diagnosis.misfit import KEY, motion_factor

SLOW, FAST = ((0.6, 20.0), (1.7, 8.0), (9.0, 0.3)), ((0.6, 2.0), (9.0, 1.6), (14.0, 0.9))  # Hz, mm


def driven(waves, name, change=0.0, size=1.0, seed=3) -> de.Recording:
    """A linear damper whose oil is soft: it is late by 1.2 ms, and as much stiffer as ``change``."""
    time = np.arange(0.0, 40.0, 1.0 / 400.0)
    lag, x, v = 1.2e-3, np.zeros(time.size), np.zeros(time.size)
    for number, (hertz, millimetres) in enumerate(waves):
        omega, phase, amplitude = 2.0 * np.pi * hertz, 0.7 * number, 1e-3 * size * millimetres
        x += amplitude * np.sin(omega * time + phase)
        gain, late = 1.0 / np.hypot(1.0, omega * lag), np.arctan(omega * lag)
        v += gain * amplitude * omega * np.cos(omega * time + phase - late)
    noise = np.random.default_rng(seed).standard_normal(time.size)
    return de.Recording.from_arrays(time, x, force=3000.0 * v + change * x + noise, name=name)


def rows(model, recording):
    return data_of(model, list(recording.measurements["damper"]), ()).unseen


@pytest.fixture(scope="module")
def line():
    """Identified on slow motion, where soft oil hardly shows; without the prediction of what it gets wrong."""
    model = de.fit(driven(SLOW, "slow"), "linear_viscous").model
    return replace(model, fit={key: value for key, value in model.fit.items() if key != KEY})


def share(model):
    return model.fit["residual_stddev"] / model.fit["force_rms"]


def test_the_error_of_the_identification_is_expected_where_it_was_found(line):
    on_it = rows(line, driven(SLOW, "slow"))
    assert recorded_profile(line.fit).expected(on_it) == pytest.approx(line.fit["residual_stddev"], rel=0.1)
    assert motion_factor(line, on_it) == pytest.approx(1.0, abs=0.1)


def test_a_larger_error_is_expected_at_the_frequencies_at_which_the_model_erred(line):
    fast = driven(FAST, "fast")
    error, on_it = de.compare(fast, line).rmse_n, rows(line, fast)
    assert error / dynamic_force(on_it) > 2.0 * share(line)
    assert recorded_profile(line.fit).expected(on_it) > 0.7 * error


def test_what_was_known_of_the_model_is_no_finding(line):
    found = de.diagnose(driven(FAST, "fast"), line, validate=driven(FAST, "again", seed=4)).only
    assert found.verdict == "nothing_missing" and not found.findings
    # Without the profile it is one.
    bare = replace(line, fit={key: value for key, value in line.fit.items() if key != error_profile.KEY})
    assert de.diagnose(driven(FAST, "fast"), bare, validate=driven(FAST, "again", seed=4)).only.findings


def test_a_change_is_found_at_these_frequencies(line):
    changed = [driven(FAST, name, change=6e4, seed=seed) for seed, name in enumerate(("fast", "again"))]
    found = de.diagnose(changed[0], line, validate=changed[1]).only
    assert found.verdict == "missing" and {"gas_spring", "spring_rate_error"} & {
        found.findings[0].phenomenon,
        *found.findings[0].tied_with,
    }


@pytest.mark.parametrize("size", [0.01, 0.3, 1.0, 4.0])
def test_no_less_than_the_same_share_is_expected(line, size):
    assert motion_factor(line, rows(line, driven(SLOW, "other", size=size))) >= 1.0


def test_it_survives_the_model_file(line, tmp_path):
    place = tmp_path / "line.yaml"
    de.save_model(line, place)
    again = recorded_profile(de.load_model(str(place)).fit)
    assert again == recorded_profile(line.fit) and again.record() == recorded_profile(line.fit).record()


def with_profile(speeds, errors, shares):
    names = ("speed_m_s", "squared_error_n2", "squared_share_by_octave")
    return {"error_profile": dict(zip(names, (speeds, errors, shares), strict=True))}


@pytest.mark.parametrize(
    "record",
    [
        {}, {"error_profile": 3}, {"error_profile": {"speed_m_s": [0.0, 1.0]}},
        with_profile([1.0, 0.0], [1.0], [0.1]), with_profile([0.0, 1.0], [float("nan")], [0.1]),
        with_profile([0.0, 1.0], [1.0, 2.0], [0.1]), with_profile([0.0, 1.0], [1.0], []),
    ],
)  # fmt: skip
def test_a_record_that_was_edited_says_nothing(line, record):
    bare = {key: value for key, value in line.fit.items() if key != error_profile.KEY}
    edited = replace(line, fit={**bare, **record})
    assert recorded_profile(record) is None
    assert motion_factor(edited, rows(line, driven(SLOW, "slow"))) == 1.0


def test_it_knows_each_speed_and_octave(line):
    """An error at one speed and one frequency stands there and nowhere else."""
    found = profile_of(line, rows(line, driven(SLOW, "slow")))
    assert len(found.errors) == len(found.speeds) - 1 and max(found.shares) <= 1.0
    assert found.shares[5] > 10.0 * found.shares[1]  # 8 to 16 Hz against 0.5 to 1 Hz
