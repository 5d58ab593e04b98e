"""A damper that drifts is reported with the time of its beginning; chance results are not."""

import numpy as np
import pytest

from damper_estimator.fleet.trend import FEWEST, drifting

DAY = 86400 * 10**9


def fleet_rows(vehicles=30, recordings=24, drift=None, since=12, seed=0, warming=0.0, forces=0.0):
    """Rows of ``compare``: errors scatter by a fifth; the vehicle ``drift`` doubles its error after ``since``."""
    draw = np.random.default_rng(seed)
    rows = []
    for vehicle in range(vehicles):
        for k in range(recordings):
            temperature, force = (
                20.0 + 10.0 * draw.standard_normal() + warming * k,
                300.0 * np.exp(0.3 * draw.standard_normal()),
            )
            error = (
                0.05 * np.exp(0.2 * draw.standard_normal() + 0.03 * (temperature - 20.0)) * (force / 300.0) ** forces
            )
            if vehicle == drift and k > since:
                error *= 1.0 + 1.5 * (k - since) / (recordings - since)
            rows.append({"vehicle": f"car {vehicle}", "damper": "left", "recording": f"{k}", "begin": k * DAY,
                         "nrmse": error, "temperature_c": temperature, "force_rms_n": force})  # fmt: skip
    return rows


def test_the_damper_that_drifts_is_reported_with_its_time():
    ((found,), judged) = drifting(fleet_rows(drift=7))
    assert (found.vehicle, found.damper, found.recordings, judged) == ("car 7", "left", 24, 30)
    assert found.low_ns <= 12 * DAY <= found.high_ns and abs(found.since_ns / DAY - 12) <= 5
    assert found.growth == pytest.approx(2.5, rel=0.35)


def test_the_order_of_the_rows_does_not_matter():
    rows = fleet_rows(drift=7)
    assert drifting(rows[::-1]) == drifting(rows)


def test_chance_is_seldom_reported():
    """Ten fleets without a drift: false alarms in two of them are tolerated."""
    alarms = [len(drifting(fleet_rows(seed=seed))[0]) > 0 for seed in range(10)]
    assert sum(alarms) <= 2


def test_changes_explained_by_temperature_and_force_are_no_drift():
    assert drifting(fleet_rows(warming=1.0, forces=0.5))[0] == []


def test_falling_errors_are_no_drift():
    rows = fleet_rows(drift=7)
    for row in rows:
        row["begin"] = 100 * DAY - row["begin"]
    assert drifting(rows)[0] == []


def test_too_few_recordings_give_no_judgement():
    assert drifting(fleet_rows(recordings=FEWEST - 1, drift=7, since=2)) == ([], 0)
    assert drifting([]) == ([], 0)


def test_rows_without_time_temperature_or_error_are_tolerated():
    rows = fleet_rows(vehicles=3)
    rows[0]["begin"] = rows[1]["nrmse"] = rows[2]["temperature_c"] = rows[3]["force_rms_n"] = None
    for row in rows[24:48]:
        row["temperature_c"] = None
    assert drifting(rows)[1] == 3
