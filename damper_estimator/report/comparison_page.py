"""The page of ``compare``: forces, where the model fails, what its effects contribute, data quality."""

from collections.abc import Sequence
from dataclasses import dataclass

from damper_estimator.report.excitation_figures import partial_coherence_figure, relative_rms_figure
from damper_estimator.report.figures import cloud_figures, coherence_figure, cycle_map, error_map, passage, time_figure
from damper_estimator.report.page import render
from damper_estimator.report.wording import (
    MEASURES,
    error_parts,
    finding_rows,
    headline,
    in_signs,
    measure_text,
    number,
    quality_rows,
    recording_name,
)
from damper_estimator.validation import Comparison, per_recording
from damper_estimator.validation.spectra import partial_coherence

POINTS = 120_000  # samples of all recordings and dampers together: about 5 MB with two models
_FEWEST = 2_000
_REGIONS = 8


@dataclass(frozen=True)
class Section:
    """One damper of the page, reduced to what is shown.

    Attributes:
        text: what the template fills in.
        figures: what the page's script draws.
    """

    text: dict[str, object]
    figures: dict[str, object]


def damper_section(comparisons: Sequence[Comparison], sections: int = 1) -> Section:
    """The part of the page about one damper.

    Args:
        comparisons: one per model, all over the same measurements.
        sections: how many dampers share the page and its size.
    """
    models = list(comparisons)
    first = models[0]
    recordings = range(len(first.traces))
    most = max(POINTS // (sections * len(recordings) * max(len(models) // 2, 1)), _FEWEST)
    names = [c.model.name for c in models]
    figures = {
        "models": names,
        "time": time_figure(names),
        "clouds": cloud_figures(names),
        "recordings": [
            passage(models, index, most) | {"name": recording_name(first.recordings[index])} for index in recordings
        ],
        "maps": [{"motion": error_map(c), "cycles": cycle_map(c)} for c in models],
        "coherence": coherence_figure(models),
        "relative_rms": relative_rms_figure(models),
        "partial_coherence": partial_coherence_figure(partial_coherence([t.measurement for t in first.traces])),
    }
    text = {
        "damper": first.damper,
        "headline": headline(models),
        "findings": finding_rows(first),
        "warnings": list(dict.fromkeys(w for c in models for w in c.warnings)),
        "models": [_model_text(c) for c in models],
        "recordings": [recording_name(path) for path in first.recordings],
        "by_recording": [_by_recording(c) for c in models] if len(recordings) > 1 else [],
        "groups": [row for c in models for row in _groups(c)],
        "grouping": _grouping(first),
        "quality": quality_rows(first),
        "chain": _chain(first),
    }
    return Section(text, figures)


def _model_text(comparison: Comparison) -> dict[str, object]:
    record = comparison.measures.record()
    largest = max(comparison.contributions.values(), default=0.0) or 1.0
    return {
        "name": comparison.model.name,
        "source": comparison.model.source,
        "parts": error_parts(comparison),
        "sentences": comparison.split.sentences,
        "samples": comparison.measures.samples,
        "measures": [
            {"name": label, "text": measure_text(key, record[key]), "unit": unit, "meaning": meaning}
            for key, label, unit, meaning in MEASURES
        ],
        "regions": [
            {
                "where": in_signs(region.where),
                "what": in_signs(region.what),
                "error": round(100.0 * region.share_of_squared_error, 1),
                "samples": round(100.0 * region.share_of_samples, 1),
                "recording": region.recording,
                "time": region.time,
            }
            for region in comparison.regions[:_REGIONS]
        ],
        "contributions": [
            {"name": label, "text": number(rms), "width": round(100.0 * rms / largest, 1)}
            for label, rms in comparison.contributions.items()
        ],
    }


def _grouping(comparison: Comparison) -> str:
    if comparison.grouping:
        return "; ".join(
            f"{name}: {', '.join(map(recording_name, recordings))}" for name, recordings in comparison.grouping.items()
        )
    return (
        "whole cycles by peak velocity (LV low, HV high) and frequency (LF low, HF high), split by the recordings' own "
        "ranges: LVLF is low velocity at low frequency, HVHF high velocity at high frequency"
    )


def _groups(comparison: Comparison) -> list[list[str]]:
    """Rows of the table of groups."""
    return [
        [
            comparison.model.name,
            group.name,
            f"{group.cycles}",
            " to ".join(number(v) for v in group.peak_velocity_m_s),
            " to ".join(number(v) for v in group.frequency_hz),
            number(group.rmse_n),
            number(100.0 * group.relative_rms),
        ]
        for group in comparison.groups
    ]


def _by_recording(comparison: Comparison) -> dict[str, object]:
    rows = []
    for recording in per_recording(comparison):
        record = recording.measures.record()
        cells = [measure_text(key, record[key]) for key, *_ in MEASURES]
        rows.append({"name": recording_name(recording.recordings[0]), "cells": cells})
    return {"model": comparison.model.name, "rows": rows}


def _chain(comparison: Comparison) -> str:
    measurement = comparison.traces[0].measurement
    cutoff = f"{measurement.cutoff:g} Hz" if measurement.cutoff else "none"
    band = f"{measurement.band:g} Hz" if measurement.band else "none"
    return (
        f"filter before the model: {cutoff}; the forces are compared below: {band}; judged from 0.2 s after a reset on"
    )


def comparison_page(sections: Sequence[Section], title: str) -> str:
    """The whole page as HTML; it is self-contained and needs no network."""
    return render(
        "page.html",
        title,
        [section.text for section in sections],
        ["page.css"],
        "page.js",
        [section.figures for section in sections],
        measures=[{"name": label, "unit": unit, "meaning": meaning} for _, label, unit, meaning in MEASURES],
    )
