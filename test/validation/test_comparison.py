"""Comparison of a model with measurements: what is judged, how several recordings go together."""

import json
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.signals import low_pass_zero_phase
from damper_estimator.validation import compare, measures, per_recording

KEYS = {
    "samples", "rmse_n", "force_rms_n", "nrmse", "esr", "fit_percent", "correlation", "peak_error_n", "energy_error",
    "bias_n", "noise_floor_n", "regions", "coherence", "data_quality",
}  # fmt: skip


def double(kinematics):
    return 3000.0 * kinematics.velocity


def test_a_right_model_has_no_error(viscous, motion, measured):
    c = compare(viscous, measured(*motion(), lambda k: 1500.0 * k.velocity))
    assert c.measures.rmse_n == pytest.approx(0.0, abs=1e-9) and c.regions == ()
    assert c.measures.correlation == pytest.approx(1.0, abs=1e-12)


def test_measures_are_those_of_judged_samples_in_band(viscous, motion, measured):
    m = measured(*motion(), double)
    c = compare(viscous, m)
    k, band = m.kinematics, m.band
    judged = k.time >= 0.2 - 1e-9
    f, g = (low_pass_zero_phase(band, k.dt, value) for value in (m.force, 1500.0 * k.velocity))
    assert c.measures == measures(f[judged], g[judged], k.velocity[judged], k.dt[judged])
    assert c.measures.samples == judged.sum()


def test_pooled_measures_weigh_recordings_by_their_samples(viscous, motion, measured):
    one, other = measured(*motion(20.0), double), measured(*motion(10.0, seed=5), double)
    together = compare(viscous, one, other)
    alone = per_recording(together)
    assert [c.measures for c in alone] == [compare(viscous, m).measures for m in (one, other)]
    square = sum(c.measures.samples * c.measures.rmse_n**2 for c in alone)
    assert together.measures.rmse_n == pytest.approx(np.sqrt(square / together.measures.samples), rel=1e-12)
    assert together.data_quality.samples == sum(c.data_quality.samples for c in alone)


def test_passages_of_one_recording_count_what_arrived_once(viscous, motion, measured):
    whole = measured(*motion(20.0), double)
    passages = [whole.part(k * 2000, (k + 1) * 2000) for k in range(4)]
    assert compare(viscous, *passages).data_quality.samples == compare(viscous, whole).data_quality.samples


def test_the_record_has_the_documented_keys_and_is_plain(viscous, motion, measured):
    from damper_estimator.files import plain

    record = compare(viscous, measured(*motion(), double)).record()
    assert KEYS <= set(record)
    assert {"where", "rmse_n", "bias_n", "share_of_squared_error"} <= set(record["regions"][0])
    assert {"gaps", "inversions", "duplicates", "non_finite", "rate_hz", "saturated", "skew_s"} <= set(
        record["data_quality"]
    )
    assert set(record["coherence"]) == {"frequency_hz", "value"}
    json.dumps(plain(record), allow_nan=False)


def test_another_filter_than_the_fits_is_reported(viscous, motion, measured):
    m = measured(*motion(5.0), double)
    fitted = replace(viscous, fit={"cutoff": 30.0})
    assert "30 Hz" in compare(fitted, m).warnings[0] and "60 Hz" in compare(fitted, m).warnings[0]
    assert compare(replace(viscous, fit={"cutoff": 60.0}), m).warnings == ()


def test_contributions_are_the_effects_shares(viscous, motion, measured):
    c = compare(viscous, measured(*motion(5.0), double))
    assert c.contributions == {"linear_viscous": pytest.approx(c.measures.force_rms_n / 2, rel=1e-9)}


def test_a_recording_shorter_than_the_warm_up_is_refused(viscous, motion, measured):
    with pytest.raises(InputError, match=r"made.mcap: damper front_left: nothing to judge"):
        compare(viscous, measured(*motion(0.15), double))


def test_samples_where_the_model_gives_no_force_are_left_out_and_reported(viscous, motion, measured):
    m = measured(*motion(10.0), double)
    m.kinematics.block[3, 2000] = np.nan
    c = compare(viscous, m)
    assert c.traces[0].lost == 1 and "1 samples" in c.warnings[0]
    left_out = ~c.traces[0].judged & m.judged
    assert left_out[2000] and abs(m.kinematics.time[left_out] - 4.0).max() <= 0.21
    assert np.isfinite(c.measures.rmse_n)


def test_a_gap_is_not_judged_for_its_warm_up(viscous, motion, measured):
    time, x = motion(10.0)
    time = np.where(time > 5.0, time + 1.0, time)
    c = compare(viscous, measured(time, x, double))
    judged_time = c.traces[0].time[c.traces[0].judged]
    assert c.data_quality.gaps == 1 and not np.any((judged_time > 5.0) & (judged_time < 6.2 - 1e-6))


def test_memory_is_some_dozens_of_numbers_per_sample(viscous, motion, measured):
    """An hour at 1 kHz is judged within a worker's limit."""
    time = np.arange(300_000) / 1000.0
    m = measured(time, 0.02 * np.sin(9.0 * time) + 0.004 * np.sin(61.0 * time), double)
    compare(viscous, m.part(0, 20_000)).record()  # what is loaded and compiled once
    tracemalloc.start()
    try:
        record = compare(viscous, m).record()
        assert record["samples"] > 299_000
        assert tracemalloc.get_traced_memory()[1] < 32 * 8 * time.size
    finally:
        tracemalloc.stop()
