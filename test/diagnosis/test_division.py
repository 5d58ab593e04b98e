"""Which part of a recording is kept back."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.diagnosis.division import divided
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.signals.layout import COMMAND, A, V, X


def speed(measurement):
    return np.quantile(np.abs(measurement.kinematics.velocity[measurement.judged]), 0.99)


def stretches(measurement):
    return len(list(measurement.kinematics.stretches()))


def changing(measurement, rows, factor):
    """With rows of the motion times a factor over the share of the recording, from 0 to 1."""
    block = measurement.kinematics.block.copy()
    block[rows] = np.nan_to_num(block[rows], nan=1.0) * factor(np.linspace(0.0, 1.0, block.shape[1]))
    return replace(measurement, kinematics=replace(measurement.kinematics, block=block))


def counted(measurement):
    """Stamps (k,) of the samples that count."""
    return measurement.kinematics.stamp[measurement.judged]


def test_the_last_two_fifths_of_each_recording_are_kept_back(user_model, base):
    data = data_of(user_model, [base, base], [])
    early, late = divided(base)
    assert [len(rows.measurement.kinematics) for rows in data.fit] == 2 * [len(early.kinematics)]
    assert len(early.kinematics) == pytest.approx(0.6 * len(base.kinematics), abs=1)
    assert np.array_equal(np.concatenate([counted(early), counted(late)]), counted(base))


def test_what_is_kept_back_begins_with_the_state_that_it_has_in_the_whole_recording(base):
    steps = changing(base, [COMMAND], lambda share: 1.0 + (np.floor(9.999 * share) % 2.0))
    field = DamperModel("m", "", (
        make_element(find_effect("command_hysteresis"), {"width": 0.2}),
        make_element(find_effect("semi_active_squash")),
    ))  # fmt: skip
    whole = field.force(steps.kinematics.block)
    for part in divided(steps):
        inside = np.isin(steps.kinematics.stamp, counted(part))
        assert field.force(part.kinematics.block)[part.judged] == pytest.approx(whole[inside], rel=0.01, abs=0.1)


def test_no_part_is_led_in_by_its_predecessor(base):
    rising = changing(base, [X, V, A], lambda share: 0.2 + np.floor(4.999 * share) / 5.0)
    for part in divided(rising):
        assert (np.diff(part.kinematics.stamp) > 0).all()


@pytest.mark.parametrize(
    ("rows", "factor"),
    [
        ([X, V, A], lambda share: np.where(share < 0.7, 0.3, 1.0)),
        ([X, V, A], lambda share: 0.2 + np.floor(4.999 * share) / 5.0),
        ([COMMAND], lambda share: np.floor(3.999 * share)),
    ],
    ids=["faster at the end", "a staircase of strokes", "a staircase of currents"],
)
def test_what_is_kept_back_does_not_go_beyond_the_rest(base, rows, factor):
    rising = changing(base, rows, factor)
    early, late = divided(rising)
    assert stretches(early) == stretches(late) > 1
    assert speed(late) < 1.3 * speed(early)
    most = [np.nanmax(part.kinematics.block[COMMAND], initial=0.0) for part in (early, late)]
    assert most[1] <= most[0]
    assert counted(late).size == pytest.approx(0.4 * len(base.kinematics), abs=8)
    assert np.array_equal(np.sort(np.concatenate([counted(early), counted(late)])), counted(base))


def test_a_recording_that_slows_down_is_not_divided_further(base):
    falling = changing(base, [X, V, A], lambda share: 1.0 - 0.8 * share)
    assert [stretches(part) for part in divided(falling)] == [1, 1]


def test_sections_are_no_shorter_than_a_second_kept_back(base):
    short = base.part(0, round(4.0 * base.kinematics.rate))
    assert [stretches(part) for part in divided(changing(short, [X, V, A], lambda share: share**2))] == [1, 1]


def test_where_no_division_helps_there_are_most_sections(base):
    early, late = divided(changing(base, [X, V, A], lambda share: np.where(np.abs(share - 0.97) < 0.025, 1.0, 0.1)))
    assert stretches(early) > 3
    assert counted(late).size == pytest.approx(0.4 * len(base.kinematics), abs=8)
