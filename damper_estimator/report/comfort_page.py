"""The page of ``comfort``: transfer functions from post to body of two models, and where they differ."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.report.page import render
from damper_estimator.report.plots import Figure, apart, axis, line, short
from damper_estimator.vehicle.comfort import AXLES, ComfortRun, Loops, differences

COLOURS = ("@model0", "@model1")


def comfort_page(car: str, names: Sequence[str], runs: Sequence[ComfortRun], others: Sequence[ComfortRun]) -> str:
    """The whole page as HTML; it needs nothing else, no network either.

    Args:
        car: its name.
        names: of both models.
        runs, others: of both models, over the same rising amplitudes.
    """
    rms = differences(runs, others)
    ends = (0, len(runs) - 1)
    figures: dict[str, Figure] = {"difference": _difference([1e3 * run.amplitude for run in runs], rms)}
    for label, k in zip(("small", "large"), ends, strict=True):
        for axle in AXLES:
            figures[f"{axle}_{label}"] = _transfer(names, [runs[k], others[k]], axle)
            figures[f"loops_{axle}_{label}"] = _loops(names, [own.begin[axle] for own in (runs[k], others[k])])
    first, last = (100 * max(rms[axle][k] for axle in AXLES) for k in ends)
    section = {
        "damper": car,
        "headline": f"on four posts: {names[0]} and {names[1]} differ by {first:.1f} % at "
        f"{1e3 * runs[0].amplitude:g} mm and by {last:.1f} % at {1e3 * runs[-1].amplitude:g} mm.",
        "amplitudes": [f"{1e3 * runs[k].amplitude:g} mm" for k in ends],
        "rows": [
            [f"{1e3 * run.amplitude:g}", *(f"{100 * rms[axle][k]:.1f}" for axle in AXLES)] for k, run in enumerate(runs)
        ],
        "axles": AXLES,
    }
    title = f"comfort of {car}: {names[0]} against {names[1]}"
    return render("comfort.html", title, [section], ["page.css"], "plots.js", apart([figures]))


def _transfer(names: Sequence[str], runs: Sequence[ComfortRun], axle: str) -> Figure:
    curves = []
    for name, run, colour in zip(names, runs, COLOURS, strict=True):
        own = run.transfer[axle]
        told = "%{x:.2f} Hz: %{y:.3f}<extra>" + name + "</extra>"
        curves.append(line(own.frequency, np.abs(own.value), name, colour, 2.0, hovertemplate=told))
    layout = {
        "xaxis": axis("frequency in Hz"),
        "yaxis": axis("body over post (1)", rangemode="tozero"),
        "showlegend": True,
    }
    return {"data": curves, "layout": layout}


def _loops(names: Sequence[str], loops: Sequence[Loops]) -> Figure:
    """Force over velocity of the left damper in the sweep's first third."""
    curves = [
        line(own.velocity, own.force, name, colour, 1.0)
        for name, own, colour in zip(names, loops, COLOURS, strict=True)
    ]
    layout = {"xaxis": axis("velocity in m/s"), "yaxis": axis("force less that at rest in N"), "showlegend": True}
    return {"data": curves, "layout": layout}


def _difference(amplitudes: Sequence[float], rms: dict[str, list[float]]) -> Figure:
    curves = [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "name": axle,
            "x": short(amplitudes),
            "y": short(100.0 * np.array(rms[axle])),
            "line": {"color": colour},
            "hovertemplate": "%{x:g} mm: %{y:.1f} %<extra>" + axle + "</extra>",
        }
        for axle, colour in zip(AXLES, ("@model2", "@model3"), strict=True)
    ]
    layout = {
        "xaxis": axis(
            "amplitude of the posts in mm", type="log", tickvals=short(amplitudes), ticktext=short(amplitudes)
        ),
        "yaxis": axis("difference in %", rangemode="tozero"),
        "showlegend": True,
    }
    return {"data": curves, "layout": layout}
