"""Errors by excitation: one for each frequency and each group; together the groups are the whole."""

import numpy as np
import pytest

from damper_estimator.signals.grouping import GroupLimits
from damper_estimator.validation.excitation_errors import given_group_errors, group_errors, relative_rms
from damper_estimator.validation.trace import trace

DAMPING = 1500.0


@pytest.fixture(scope="module")
def traces(measured, viscous):
    """Sine tests whose force is larger than the model's by a share that depends on the test."""

    def make(*tests):
        found = []
        for frequency, amplitude, share in tests:
            time = np.arange(round(6.0 * 500.0)) / 500.0
            x = amplitude * np.sin(2.0 * np.pi * frequency * time)
            found.append(trace(viscous, measured(time, x, lambda k, s=share: DAMPING * (1.0 + s) * k.velocity)))
        return found

    return make


def test_the_relative_error_is_reported_for_every_excitation_frequency(traces):
    rows = relative_rms(traces((1.0, 0.02, 0.1), (4.0, 0.01, 0.25), (10.0, 0.002, 0.5)))
    assert [row.frequency_hz for row in rows] == pytest.approx([1.0, 4.0, 10.0], rel=0.01)
    assert [row.relative_rms for row in rows] == pytest.approx([s / (1.0 + s) for s in (0.1, 0.25, 0.5)], rel=1e-3)


def test_a_perfect_model_has_no_error_at_any_frequency(traces):
    assert all(row.relative_rms < 1e-9 for row in relative_rms(traces((1.0, 0.02, 0.0), (4.0, 0.01, 0.0))))


def test_groups_form_from_the_recordings_own_ranges(traces):
    errors = group_errors(traces((1.5, 0.02, 0.1), (12.0, 0.002, 0.2), (12.0, 0.010, 0.4)))
    assert [e.name for e in errors] == ["LVLF", "LVHF", "HVHF"]
    assert [e.relative_rms for e in errors] == pytest.approx([s / (1.0 + s) for s in (0.1, 0.2, 0.4)], rel=1e-3)
    assert errors[2].peak_velocity_m_s[0] > errors[1].peak_velocity_m_s[1]


def test_given_limits_are_kept(traces):
    errors = group_errors(traces((1.5, 0.02, 0.1), (12.0, 0.002, 0.2)), GroupLimits(np.inf, 5.0))
    assert [e.name for e in errors] == ["LF", "HF"]


def test_groups_of_whole_recordings_go_by_the_users_names(traces):
    three = traces((1.5, 0.02, 0.1), (12.0, 0.002, 0.2), (12.0, 0.010, 0.4))
    errors = given_group_errors(three, {"comfort": [0, 1], "track": [2]})
    assert [(e.name, e.recordings) for e in errors] == [("comfort", 2), ("track", 1)]
    squares = [np.mean(t.residual[t.judged] ** 2) for t in three[:2]]
    assert errors[0].mean_square_n2 == pytest.approx(np.mean(squares))


def test_given_groups_that_hold_everything_add_up_to_the_whole(traces):
    three = traces((1.5, 0.02, 0.1), (12.0, 0.002, 0.2), (12.0, 0.010, 0.4))
    (whole,) = given_group_errors(three, {"all": range(3)})
    parts = given_group_errors(three, {str(i): [i] for i in range(3)})
    assert whole.samples == sum(p.samples for p in parts)
    assert whole.rmse_n**2 * whole.samples == pytest.approx(sum(p.rmse_n**2 * p.samples for p in parts))
