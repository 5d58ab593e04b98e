"""Forces before and after: errors as they are judged, the worst passage, and shares that add up."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis import corrected
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.report.before_after import before_after, explained


def with_unseen(found, *unseen):
    return replace(found, unseen=tuple(unseen))


def test_errors_are_modelled_less_measured_in_band_where_they_are_judged(found):
    shown = before_after(found)
    (recording,), trace = shown.recordings, shown.before.traces[0]
    inside = recording.judged
    assert np.isnan(recording.error_before[~inside]).all()
    assert recording.error_before[inside] == pytest.approx((trace.residual - recording.zero)[inside])
    assert recording.error_after[inside] == pytest.approx((shown.after.traces[0].residual - recording.zero)[inside])


def test_the_gauges_zero_and_drift_change_nothing(found):
    plain = found.unseen[0]
    drifting = replace(plain, force=plain.force + 25.0 + 3.0 * plain.kinematics.time)
    a, b = (before_after(with_unseen(found, measurement)).recordings[0] for measurement in (plain, drifting))
    inner = a.judged & (a.time > 0.5) & (a.time < a.time[-1] - 0.5)  # the band's filter rings at the ends
    assert b.error_after[inner] == pytest.approx(a.error_after[inner], abs=0.05)
    assert b.error_before[inner] == pytest.approx(a.error_before[inner], abs=0.05)
    assert np.mean(b.zero) - np.mean(a.zero) == pytest.approx(-25.0 - 3.0 * np.mean(a.time), abs=0.1)


def test_the_worst_passage_is_where_a_burst_of_error_was_planted(found, measured):
    calm, loud = measured(3), measured(4)
    burst = 400.0 * np.exp(-(((loud.kinematics.time - 5.0) / 0.05) ** 2))
    shown = before_after(with_unseen(found, calm, replace(loud, force=loud.force + burst)))
    start, end = shown.worst.worst
    assert shown.worst.path == loud.recording and start < 5.0 < end
    rows = shown.worst.passage_rows()
    assert shown.worst.time[rows[0]] >= start and shown.worst.time[rows[-1]] <= end


def test_what_an_effect_explains_and_what_is_left_make_up_what_was_missing(found):
    shown = before_after(found)
    part = explained(shown, found.findings[0])
    inside = shown.worst.judged
    assert (part.missing - part.part)[inside] == pytest.approx(-shown.worst.error_after[inside], abs=1e-9)
    assert np.sqrt(np.mean(part.part[inside] ** 2)) > 30.0  # of 60 N of friction


def test_a_correction_of_the_chain_explains_what_it_changes_of_the_measured_force(found):
    signals = replace(found.signals, force=replace(found.signals.force, offset=-40.0))
    finding = replace(found.findings[0], effect="force_offset", phenomenon="force_offset", is_channel=True)
    shown = before_after(replace(found, findings=(finding,), signals=signals, improved=found.model))
    part = explained(shown, finding)
    assert shown.corrected and shown.changed
    assert part.part[shown.worst.judged] == pytest.approx(40.0, abs=1e-6)
    twice = corrected(corrected(found.unseen[0], signals), signals)
    assert twice.force == pytest.approx(found.unseen[0].force - 40.0)


def test_nothing_to_show_after_where_nothing_changed(found):
    shown = before_after(replace(found, findings=(), improved=found.model))
    assert not shown.changed and not shown.corrected


def test_shares_of_effects_inside_a_compliance_add_up_to_the_force(found):
    outer = make_element(find_effect("oil_spring"), {}, found.model.effects)
    model = replace(found.model, effects=(outer, make_element(find_effect("static_force"), {"force": 100.0})))
    shown = before_after(replace(found, improved=model))
    seen = shown.after.contributions
    assert set(seen) == {"oil_spring", "linear_viscous", "static_force"}
    assert seen["static_force"] == pytest.approx(100.0, rel=0.01)
    force = np.sqrt(np.mean((1500.0 * found.unseen[0].kinematics.velocity) ** 2))
    assert seen["linear_viscous"] == pytest.approx(force, rel=0.1) and seen["oil_spring"] < 0.3 * force


def test_the_found_instance_is_distinguished_from_another_of_the_same_effect(found):
    finding = found.findings[0]
    element = found.elements[0]
    halved = element.with_values(
        {name: 0.5 * value for name, value in element.parameters.items() if np.isscalar(value)}
    )
    both = replace(found.model, effects=(*found.model.effects, halved, element))
    shown = before_after(replace(found, improved=both))
    part = explained(shown, finding)
    alone = element.effect.name
    unseen = shown.after.traces[0].measurement
    expected = unseen.in_band(both.contributions(unseen.kinematics.block)[f"{alone}#2"])
    assert part.part == pytest.approx(expected, abs=1e-6)
