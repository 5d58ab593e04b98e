"""The page: self-contained, safe, small, and no peak lost."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.report import comparison_page, damper_section, min_max_rows
from damper_estimator.report.page import _plotly
from damper_estimator.signals import Counts, Measurement, default_signals
from damper_estimator.signals.kinematics import Differentiator
from damper_estimator.validation import compare

LIMIT = 8_000_000  # characters besides the library
VISCOUS = DamperModel("viscous", "", (make_element(find_effect("linear_viscous")),))


def measurement(size=3000, name="front_left", gap=False):
    stamp = np.arange(size, dtype=np.int64) * 1_000_000
    if gap:
        stamp[size // 2 :] += 10**9
    x = 0.01 * np.sin(2 * np.pi * 1.7 * stamp * 1e-9) + 1e-4 * np.random.default_rng(0).standard_normal(size)
    kinematics, verdict = Differentiator(60.0, 0.1).block(stamp, x)
    force = 2000.0 * kinematics.velocity
    return Measurement(
        f"/data/{name}.mcap",
        name,
        kinematics,
        force,
        kinematics.warm(),
        Counts.of(verdict),
        force,
        x,
        60.0,
        30.0,
        default_signals(name),
    )


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S).group(1))


def unpacked(column):
    return np.frombuffer(base64.b64decode(column["bdata"]), dtype=f"<{column['dtype']}")


def test_the_page_needs_no_network():
    page = comparison_page([damper_section([compare(VISCOUS, measurement())])], "title")
    text = page.replace(_plotly(), "")
    assert not re.search(r"https?://", text)
    assert not re.search(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=[\"'](?!data:)", page)


def test_names_from_files_cannot_become_markup():
    evil = "</script><b>&"
    model = DamperModel(evil, "", VISCOUS.effects)
    page = comparison_page([damper_section([compare(model, measurement(name=evil))])], evil)
    text = page.replace(_plotly(), "")
    assert evil not in text and "&lt;/script&gt;" in text
    assert data_of(text)[0]["models"] == [evil]


def test_the_embedded_signals_are_the_compared_ones():
    c = compare(VISCOUS, measurement())
    (recording,) = data_of(comparison_page([damper_section([c])], "t"))[0]["recordings"]
    trace = c.traces[0]
    assert np.array_equal(unpacked(recording["time"]), trace.time)
    assert np.array_equal(unpacked(recording["measured"]), trace.measured.astype(np.float32))
    modelled = unpacked(recording["modelled"][0])
    assert np.array_equal(np.isnan(modelled), ~trace.judged)
    assert np.array_equal(modelled[trace.judged], trace.modelled[trace.judged].astype(np.float32))


def test_a_gap_breaks_the_lines():
    c = compare(VISCOUS, measurement(gap=True))
    (recording,) = data_of(comparison_page([damper_section([c])], "t"))[0]["recordings"]
    time, measured = unpacked(recording["time"]), unpacked(recording["measured"])
    (hole,) = np.flatnonzero(np.isnan(measured))
    assert time[hole - 1] < time[hole] < time[hole + 1] and time[hole + 1] - time[hole - 1] > 1.0


def test_hours_of_data_stay_small_and_keep_their_peaks():
    long = measurement(700_000)
    long.force[234_567] += 50_000.0
    c = compare(VISCOUS, long)
    page = comparison_page([damper_section([c, c], 2) for _ in range(2)], "t")
    assert len(page) - len(_plotly()) < LIMIT
    for section in data_of(page):
        measured = unpacked(section["recordings"][0]["measured"])
        assert measured.max() == np.float32(c.traces[0].measured.max())


def test_words_and_numbers_are_there_without_script():
    page = comparison_page([damper_section([compare(VISCOUS, measurement())])], "t").replace(_plotly(), "")
    body = re.sub(r"<script.*?</script>", "", page, flags=re.S)
    for word in ("rms error", "ESR", "linear_viscous", "saturated", "front_left"):
        assert word in body


def test_mistakes_of_the_data_come_before_the_numbers():
    clipped = measurement(20_000)
    limit = 0.7 * clipped.force.max()
    m = replace(clipped, gauge=np.minimum(clipped.gauge, limit), force=clipped.force + 20.0)
    page = comparison_page([damper_section([compare(VISCOUS, m)])], "t").replace(_plotly(), "")
    body = re.sub(r"<script.*?</script>", "", page, flags=re.S)
    assert body.index("Data before physics") < body.index("rms error")
    assert f"the gauge clips at {limit:.4g} N" in body and "The measurement comes first" in body
    assert "what to do: they and the filtered samples around them are left out" in body


def test_what_the_error_is_made_of_is_shown():
    m = measurement(20_000)
    c = compare(VISCOUS, replace(m, force=VISCOUS.force(m.kinematics.block) + 20.0))
    page = comparison_page([damper_section([c])], "t").replace(_plotly(), "")
    widths = {name: float(w) for name, w in re.findall(r'<span class="(\w+)" style="width:([\d.]+)%"></span>', page)}
    shown = {name: widths[name] for name in ("zero", "drift", "gain", "scatter")}
    assert sum(shown.values()) == pytest.approx(100.0, abs=0.1) and max(shown, key=shown.get) == "zero"
    assert "The measured force is 20 N high throughout" in page


@given(st.integers(2, 400), st.integers(1, 3), st.integers(8, 60), st.integers(0, 1000))
def test_min_max_rows_keep_extremes_and_ends_and_their_number(size, count, most, seed):
    signals = list(np.random.default_rng(seed).normal(size=(count, size)))
    rows = min_max_rows(signals, most)
    assert rows.size <= max(most, min(size, 2)) and np.all(np.diff(rows) > 0) and rows[0] == 0 and rows[-1] == size - 1
    for values in signals:
        assert values[rows].max() == values.max() and values[rows].min() == values.min()


def test_min_max_rows_pass_over_holes():
    values = np.arange(1000.0)
    values[300:700] = np.nan
    rows = min_max_rows([values], 50)
    assert np.nanmax(values[rows]) == 999.0 and rows.size <= 50


@pytest.mark.parametrize("kind", ["f4", "f8"])
def test_packed_arrays_read_back(kind):
    from damper_estimator.report.packing import packed

    values = np.array([1.0, np.nan, -2.5e7])
    assert np.array_equal(unpacked(packed(values, kind)), values.astype(f"<{kind}"), equal_nan=True)
