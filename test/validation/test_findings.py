"""Data before physics: mistakes of the measurement chain are found, named and corrected; good recordings have none."""

import re
from dataclasses import replace

import numpy as np
import pytest
import yaml

from damper_estimator.model import load_model
from damper_estimator.signals import parse_signal_map
from damper_estimator.signals.layout import COMMAND
from damper_estimator.validation import compare, data_findings

RMS = 380.0  # N, about that of the damper and excitation that most tests take
SPRING = 28000.0


def kinds(*measurements, model=None):
    return [finding.kind for finding in data_findings(model, measurements)]


def only(measurement, model=None):
    """The one finding of a recording."""
    found = data_findings(model, [measurement])
    assert len(found) == 1, found
    return found[0]


def values(role, of):
    """A logger that writes ``of(time, value)`` instead of the values."""

    def change(channels):
        channel = channels[role]
        return channels | {role: replace(channel, value=of(channel.stamp / 1e9, channel.value))}

    return change


def stamps(role, of):
    """A logger that writes ``of(time)`` instead of the times."""

    def change(channels):
        channel = channels[role]
        return channels | {role: replace(channel, stamp=np.round(1e9 * of(channel.stamp / 1e9)).astype(np.int64))}

    return change


def without(role, lost):
    """A logger that loses the samples for which ``lost(time)``."""

    def change(channels):
        channel = channels[role]
        kept = ~lost(channel.stamp / 1e9)
        return channels | {role: type(channel)(channel.log[kept], channel.stamp[kept], channel.value[kept])}

    return change


def repeated(role, times):
    """A logger that is faster than its sensor."""

    def change(channels):
        channel = channels[role]
        return channels | {role: replace(channel, value=channel.value[np.arange(channel.value.size) // times * times])}

    return change


def with_spring(rate):
    def change(channels):
        x, force = channels["displacement"], channels["force"]
        more = rate * np.interp(force.stamp, x.stamp, x.value)
        return channels | {"force": replace(force, value=force.value + more)}

    return change


@pytest.mark.parametrize("damper", ["passenger_front", "rally_rear", "light_car", "semi_active"])
@pytest.mark.parametrize(("excitation", "seed"), [("random", 1), ("road", 2), ("dyno", 3)])
def test_a_good_recording_has_no_finding(damper, excitation, seed, recorded):
    assert kinds(recorded(damper, excitation, seed)) == []


@pytest.mark.parametrize(
    "sensors",
    [{"rate": 200.0}, {"rate": 2000.0}, {"force_noise": 40.0}, {"displacement_noise": 1e-4}, {"force_step": 20.0}],
    ids=str,
)
def test_noise_and_rates_are_no_mistakes(sensors, recorded):
    assert kinds(recorded(**sensors)) == []


def test_a_shaken_damper_of_another_day_is_no_mistake(recorded):
    """Other excitations of one damper: its force at standstill is the same."""
    assert kinds(recorded(), recorded(excitation="road", seed=2), recorded(excitation="dyno", seed=3)) == []


def test_a_clipped_gauge_is_named_with_its_limit(recorded):
    finding = only(recorded(saturation=700.0))
    assert finding.kind == "saturation" and "-700 N and 700 N" in finding.sentence
    assert 0.0 < finding.share < 0.2


@pytest.mark.parametrize("role", ["displacement", "force"])
def test_gaps_and_lost_samples_are_distinguished(role, recorded):
    gap = only(recorded(change=without(role, lambda t: (t > 8.0) & (t < 9.5))))
    assert gap.kind == "gaps" and f"the {role} has 1 gap of 1.5 s" in gap.sentence
    assert gap.share == pytest.approx(1.5 / 20.0, rel=0.02)
    few = only(recorded(change=without(role, lambda t: np.random.default_rng(1).random(t.size) < 0.05)))
    assert few.kind == "gaps" and "missing one by one" in few.sentence and few.share == pytest.approx(0.05, rel=0.2)


@pytest.mark.parametrize("role", ["displacement", "force"])
def test_a_wrong_sign_is_named_and_its_remedy_corrects_it(role, recorded):
    turned = values(role, lambda t, v: -v)
    model = load_model("carrera_akutain", "passenger_front")
    finding = only(recorded(change=turned), model)
    assert finding.kind == "sign" and f": {role} has the wrong sign" in finding.sentence
    assert kinds(recorded(change=turned, signal_map=corrected(finding))) == []
    unknown = only(recorded(change=turned))
    assert "force or displacement" in unknown.sentence and "push the damper together" in unknown.remedy


def corrected(finding):
    """The signal map with the first line that a correction says to write."""
    line = yaml.safe_load(re.search(r"`([^`]*)`", finding.remedy).group(1))
    content = line if "filter" in line or "use" in line else {"dampers": {"passenger_front": line}}
    return parse_signal_map(content, "corrected")


def test_an_offset_turns_with_the_sign(recorded):
    mirrored = parse_signal_map({"dampers": {"passenger_front": {"force": {"scale": 2.0, "offset": 30.0}}}}, "map")
    finding = only(recorded(change=values("force", lambda t, v: -0.5 * v), signal_map=mirrored))
    force = corrected(finding).dampers["passenger_front"].force
    assert (force.scale, force.offset) == (-2.0, -30.0)


def test_a_drift_of_the_zero_is_reported_in_newtons_and_time(recorded):
    finding = only(recorded(change=values("force", lambda t, v: v + 80.0 * np.clip(t - 5.0, 0.0, 10.0) / 10.0)))
    assert finding.kind == "zero_drift"
    drift, begin, end = (float(x) for x in re.findall(r"[-+]?\d+\.?\d*", finding.sentence))
    assert drift == pytest.approx(80.0, abs=12.0) and begin < 8.0 and end > 14.0
    assert corrected(finding).windows[0][1] - corrected(finding).windows[0][0] == pytest.approx(9.0, abs=1.0)


def test_a_force_that_differs_with_the_position_at_rest_is_no_drift(recorded):
    def gas(channels):
        moved = values("displacement", lambda t, x: x + 0.02 * np.clip(t - 9.0, 0.0, 1.0))(channels)
        x = np.interp(moved["force"].stamp, moved["displacement"].stamp, moved["displacement"].value)
        return values("force", lambda t, force: force - 2e5 * np.maximum(x, 0.0) ** 2)(moved)

    assert "zero_drift" not in kinds(recorded(change=gas))


def test_zeros_that_differ_between_recordings_are_reported(recorded):
    one, other = recorded(), recorded(seed=2, change=values("force", lambda t, v: v + 60.0))
    finding = data_findings(None, [one, other])[0]
    assert (finding.kind, finding.recording) == ("zero_differs", "")
    assert f"higher in {other.recording}" in finding.sentence
    assert float(re.search(r"is ([\d.]+) N", finding.sentence).group(1)) == pytest.approx(60.0, abs=10.0)


def test_a_force_that_another_current_may_explain_hides_no_zero(recorded):
    def at(measurement, current):
        block = measurement.kinematics.block.copy()
        block[COMMAND] = current
        return replace(measurement, kinematics=replace(measurement.kinematics, block=block))

    offsets = {1: 0.0, 2: 60.0, 3: 300.0}
    one, other, far = (recorded(seed=s, change=values("force", lambda t, v, o=o: v + o)) for s, o in offsets.items())
    assert "zero_differs" not in kinds(at(one, 0.0), at(far, 1.0))
    found = data_findings(None, [at(one, 0.0), at(other, 0.0), at(far, 1.0)])
    sentence = next(finding.sentence for finding in found if finding.kind == "zero_differs")
    assert f"higher in {other.recording} than in {one.recording}" in sentence


@pytest.mark.parametrize("role", ["displacement", "force"])
def test_a_dead_channel_is_named(role, recorded):
    finding = only(recorded(change=values(role, lambda t, v: 0.0 * v + 0.003)))
    assert finding.kind == "dead_channel" and f"the {role} never changes" in finding.sentence


def test_a_gauge_of_another_damper_is_dead_for_this_one(recorded):
    noise = np.random.default_rng(0)
    finding = only(recorded(change=values("force", lambda t, v: 300.0 * noise.standard_normal(v.size))))
    assert finding.kind == "dead_channel" and "does not follow the motion" in finding.sentence


@pytest.mark.parametrize(("role", "factor"), [("displacement", 1e3), ("displacement", -1e3), ("force", 1e-3)])
def test_millimetres_and_kilonewtons_are_named_and_corrected(role, factor, recorded):
    finding = only(recorded(change=values(role, lambda t, v: factor * v)))
    assert finding.kind == "unit" and finding.spoils
    assert ("in mm" if role == "displacement" else "in kN") in finding.sentence
    assert getattr(corrected(finding).dampers["passenger_front"], role).scale == pytest.approx(1.0 / abs(factor))


def test_a_weak_gauge_that_does_not_follow_the_motion_is_dead_and_not_in_kilonewtons(recorded):
    noise = np.random.default_rng(0)
    finding = only(recorded(change=values("force", lambda t, v: 0.5 * noise.standard_normal(v.size))))
    assert finding.kind == "dead_channel" and "does not follow the motion" in finding.sentence


def test_of_two_wrong_units_the_displacement_comes_first(recorded):
    """In both, the force over the velocity is a millionth: the stroke alone tells the channels apart."""
    both = recorded(change=values("displacement", lambda t, v: 1e3 * v))
    assert "in mm" in only(replace(both, force=1e-3 * both.force)).sentence


@pytest.mark.parametrize("role", ["displacement", "force"])
def test_a_logger_that_repeats_values_is_named_and_the_lateness_corrected(role, recorded):
    finding = only(recorded(change=repeated(role, 5)))
    assert finding.kind == "held" and "comes 5 times" in finding.sentence
    channel = getattr(corrected(finding).dampers["passenger_front"], role)
    assert channel.skew == pytest.approx(0.004, abs=2e-4)


def test_coarse_steps_of_the_displacement_are_named_and_the_cutoff_reduces_them(recorded):
    finding = only(recorded(displacement_step=5e-4))
    assert finding.kind == "quantisation" and "steps of 0.5 mm" in finding.sentence
    assert corrected(finding).cutoff < 60.0
    assert kinds(recorded(displacement_step=5e-4, signal_map=corrected(finding))) == []


def test_coarse_steps_of_the_gauge_are_named(recorded):
    finding = only(recorded(force_step=150.0))
    assert finding.kind == "quantisation" and "the gauge comes in steps of 150 N" in finding.sentence


def test_a_rate_too_low_for_the_filter_is_named_and_corrected(recorded):
    finding = only(recorded(rate=100.0))
    assert finding.kind == "rate" and "50 Hz" in finding.sentence
    assert kinds(recorded(rate=100.0, signal_map=corrected(finding))) == []


def test_rounded_equal_and_uneven_stamps_are_distinguished(recorded):
    sentences = [
        only(recorded(rate=300.0, change=stamps("displacement", lambda t: np.round(t, 3)))).sentence,
        only(recorded(change=stamps("force", lambda t: np.round(t, 2)))).sentence,
        only(recorded(change=stamps("displacement", jittering))).sentence,
    ]
    assert "rounded to 1 ms" in sentences[0] and "repeat the one before" in sentences[1] and "uneven" in sentences[2]


@pytest.mark.parametrize("rate", [128.0, 300.0, 512.0, 1200.0, 3000.0])
def test_even_stamps_of_any_rate_are_not_called_rounded(rate, recorded):
    def even(channels):
        channel = channels["displacement"]
        stamp = channel.stamp[0] + np.round(1e9 * np.arange(channel.stamp.size) / rate).astype(np.int64)
        return channels | {"displacement": replace(channel, stamp=stamp)}

    assert "stamps" not in kinds(recorded(rate=rate, change=even))


def jittering(time):
    return np.sort(time + 1e-3 * np.random.default_rng(1).standard_normal(time.size))


def test_clocks_that_run_apart_are_reported_in_ppm(recorded):
    finding = only(recorded(change=stamps("force", lambda t: t * (1.0 + 200e-6))))
    assert finding.kind == "clock_drift" and "slow" in finding.sentence
    assert float(re.search(r"runs ([\d.e+]+) ppm", finding.sentence).group(1)) == pytest.approx(200.0, rel=0.15)


def test_a_few_seconds_show_no_clock(recorded):
    m = recorded(change=stamps("force", lambda t: t * (1.0 + 2000e-6)))
    assert "clock_drift" in kinds(m)
    seconds = round(m.kinematics.rate)
    assert "clock_drift" not in kinds(m.part(0, 7 * seconds))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_spring_in_the_gauge_is_a_hint_with_its_rate(sign, recorded):
    finding = only(recorded(excitation="road", change=with_spring(sign * SPRING)))
    assert finding.kind == "spring"
    rate = corrected(finding).dampers["passenger_front"].spring_rate
    assert rate == pytest.approx(sign * SPRING, rel=0.15)
    assert kinds(recorded(excitation="road", change=with_spring(sign * SPRING), signal_map=corrected(finding))) == []


def test_what_is_said_of_parts_of_a_recording_is_said_once(recorded):
    m = recorded(saturation=700.0)
    half = len(m.kinematics) // 2
    assert kinds(m.part(0, half), m.part(half, 2 * half)) == ["saturation"]


def test_compare_reports_the_findings_with_the_quality_of_the_data(viscous, recorded):
    record = compare(viscous, recorded(saturation=700.0)).record()["data_quality"]
    assert [finding["kind"] for finding in record["findings"]] == ["saturation"] and record["saturated"] > 0
    assert set(record["findings"][0]) == {"kind", "sentence", "remedy", "recording", "share"}
