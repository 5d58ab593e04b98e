"""Curves over frequency: the relative error by excitation, and the share of the force that each signal explains."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.report.plots import TIGHT, axis
from damper_estimator.report.theme import model_colour
from damper_estimator.validation import Comparison
from damper_estimator.validation.spectra import PartialCoherence


def relative_rms_figure(comparisons: Sequence[Comparison]) -> dict[str, object] | None:
    """rms error over rms force by frequency of the excitation, one curve per model; None without a whole cycle."""
    curves = [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "line": {"color": model_colour(index), "width": 1.6},
            "marker": {"size": 5},
            "name": c.model.name,
            "x": [round(row.frequency_hz, 4) for row in c.relative_rms],
            "y": [_percent(row.relative_rms) for row in c.relative_rms],
            "text": [f"{row.cycles} cycles" for row in c.relative_rms],
            "hovertemplate": "%{x:.3g} Hz: %{y:.3g} %, %{text}<extra>%{fullData.name}</extra>",
        }
        for index, c in enumerate(comparisons)
        if c.relative_rms
    ]
    if not curves:
        return None
    layout = {
        "xaxis": axis("frequency of the excitation in Hz"),
        "yaxis": axis("rms error over rms force in %", rangemode="tozero"),
        "margin": TIGHT,
        "showlegend": len(curves) > 1,
    }
    return {"data": curves, "layout": layout}


def partial_coherence_figure(found: PartialCoherence) -> dict[str, object] | None:
    """Partial coherence of the measured force by input; None where the recordings are too short."""
    if not found.frequency.size:
        return None
    curves = [
        {
            "type": "scatter",
            "mode": "lines",
            "line": {"color": model_colour(index), "width": 1.6},
            "name": name,
            "x": np.round(found.frequency, 4).tolist(),
            "y": [float(f"{v:.4g}") if np.isfinite(v) else None for v in value],
            "hovertemplate": "%{x:.3g} Hz: %{y:.3f}<extra>%{fullData.name}</extra>",
        }
        for index, (name, value) in enumerate(found.partial.items())
    ]
    layout = {
        "xaxis": axis("frequency in Hz"),
        "yaxis": axis("partial coherence (1)", range=[0.0, 1.03]),
        "margin": TIGHT,
        "showlegend": True,
    }
    return {"data": curves, "layout": layout}


def _percent(value: float) -> float | None:
    return float(f"{100.0 * value:.4g}") if np.isfinite(value) else None
