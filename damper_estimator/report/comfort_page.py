"""The page of ``comfort``: transfer functions from post to body of two models, and where they differ."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.report.packing import unpacked
from damper_estimator.report.page import render
from damper_estimator.report.plots import Figure, axis, line, shared_arrays, short
from damper_estimator.vehicle.comfort import AXLES, ComfortRun, Loops, differences

COLOURS = ("@model0", "@model1")


def comfort_page(car: str, names: Sequence[str], runs: Sequence[ComfortRun], others: Sequence[ComfortRun]) -> str:
    """The whole page as HTML; it is self-contained and needs no network.

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
            figures[f"loops_{axle}_{label}"] = _loops(names, [run.begin[axle] for run in (runs[k], others[k])])
    _share(figures, [f"{axle}_{label}" for label in ("small", "large") for axle in AXLES], "y")
    for label in ("small", "large"):
        _share(figures, [f"loops_{axle}_{label}" for axle in AXLES], "xy")
    first, last = (100 * max(rms[axle][k] for axle in AXLES) for k in ends)
    section = {
        "damper": car,
        "headline": f"{_for_drivers(names, runs, others)} In amplitude and phase together they differ by {first:.1f} % "
        f"at {1e3 * runs[0].amplitude:g} mm and by {last:.1f} % at {1e3 * runs[-1].amplitude:g} mm.",
        "amplitudes": [f"{1e3 * runs[k].amplitude:g} mm" for k in ends],
        "rows": [
            [f"{1e3 * run.amplitude:g}", *(f"{100 * rms[axle][k]:.1f}" for axle in AXLES)] for k, run in enumerate(runs)
        ],
        "axles": AXLES,
    }
    title = f"comfort of {car}: {names[0]} against {names[1]}"
    return render("comfort.html", title, [section], ["page.css"], "plots.js", shared_arrays([figures]))


def _for_drivers(names: Sequence[str], runs: Sequence[ComfortRun], others: Sequence[ComfortRun]) -> str:
    """How much more the body moves with one model than with the other, on small and on large bumps."""
    parts = []
    for size, k in (("small", 0), ("large", -1)):
        ratios = []
        for axle in AXLES:
            one, other = (np.abs(each[k].transfer[axle].value) for each in (runs, others))
            ratios.append(100.0 * (float(np.sqrt(np.mean(one**2) / np.mean(other**2))) - 1.0))
        words = [f"{abs(ratio):.0f} % {'more' if ratio >= 0.0 else 'less'} at the {axle}"
                 for ratio, axle in zip(ratios, AXLES, strict=True)]  # fmt: skip
        parts.append(f"on {size} bumps ({1e3 * runs[k].amplitude:g} mm) the body moves {' and '.join(words)}")
    return f"with {names[0]} instead of {names[1]}, {'; '.join(parts)}."


def _share(figures: dict[str, Figure], names: Sequence[str], axes: str) -> None:
    """The same range on the axes of figures that stand side by side."""
    for letter in axes:
        values = np.concatenate([unpacked(figure[letter]) for name in names for figure in figures[name]["data"]])
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        ends = [low - 0.04 * (high - low), high + 0.04 * (high - low)]
        for name in names:
            axis_of = figures[name]["layout"][f"{letter}axis"]
            axis_of.pop("rangemode", None)
            axis_of["range"] = [0.0, ends[1]] if low >= 0.0 and letter == "y" else ends


def _transfer(names: Sequence[str], runs: Sequence[ComfortRun], axle: str) -> Figure:
    curves = []
    for name, run, colour in zip(names, runs, COLOURS, strict=True):
        transfer = run.transfer[axle]
        hover = "%{x:.2f} Hz: %{y:.3f}<extra>" + name + "</extra>"
        curves.append(line(transfer.frequency, np.abs(transfer.value), name, colour, 2.0, hovertemplate=hover))
    layout = {
        "xaxis": axis("frequency in Hz"),
        "yaxis": axis("body over post (1)", rangemode="tozero"),
        "showlegend": True,
    }
    return {"data": curves, "layout": layout}


def _loops(names: Sequence[str], loops: Sequence[Loops]) -> Figure:
    """Force over velocity of the left damper in the sweep's first third."""
    curves = [
        line(loop.velocity, loop.force, name, colour, 1.0)
        for name, loop, colour in zip(names, loops, COLOURS, strict=True)
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
