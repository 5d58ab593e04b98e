"""The page of a plan: what will differ, and the predicted probabilities over the length of the test."""

from collections.abc import Mapping, Sequence

import numpy as np

from damper_estimator.numbers import number
from damper_estimator.planning import Limits, Plan
from damper_estimator.report.decimation import min_max_rows
from damper_estimator.report.page import render
from damper_estimator.report.plots import GREY, INK, Figure, axis, line, shared_arrays, short

COLOURS = ("@model0", "@model1", "@model2", "@model3", "@error")
_MOST = 4000  # points of the drive


def plan_page(plans: Mapping[str, Plan], title: str) -> str:
    """The whole page as HTML; it is self-contained and needs no network.

    Args:
        plans: by damper.
    """
    sections = [_section(damper, plan) for damper, plan in plans.items()]
    figures = [_figures(plan) for plan in plans.values()]
    return render("plan.html", title, sections, ["page.css"], "plots.js", shared_arrays(figures))


def plan_figure(plan: Plan) -> Figure:
    """Force of every hypothesis over time on the step that shows the difference best."""
    return _force(plan)


def _section(damper: str, plan: Plan) -> dict[str, object]:
    return {
        "damper": damper,
        "headline": plan.sentence,
        "clearest": plan.clearest,
        "several": len(plan.force) > 1,
        "predicted": plan.chances is not None,
        "played": plan.rig.kind != "manoeuvres",
        "steps": [
            [words, *(f"{step.record()[key]:.3g}" for key in ("speed_m_s", "acceleration_m_s2"))]
            for step, words in plan.listed
        ],
        "limits": _limits(plan.limits),
        "parameters": [
            [one.address, f"{one.value:.4g}", f"{one.before:.2g}", f"{one.after:.2g}"] for one in plan.parameters
        ],
        "would": list(plan.would),
    }


def _limits(limits: Limits) -> list[list[str]]:
    """Each limit in words, its value and its unit."""
    rows: list[tuple[str, Sequence[float], str]] = [
        ("displacement", [1e3 * limits.low, 1e3 * limits.high], "mm"),
        ("speed", [limits.speed], "m/s"),
        ("acceleration", [limits.acceleration], "m/s²"),
        ("force", [limits.force], "N"),
        ("frequency", limits.frequency, "Hz"),
        ("temperatures", limits.temperature, "°C"),
        ("currents", limits.current, "A"),
    ]
    found = [
        [name, (" to " if name in ("displacement", "frequency") else ", ").join(map(number, values)), unit]
        for name, values, unit in rows if len(values)
    ]  # fmt: skip
    mean = "any within the displacement" if limits.mean_positions else number(1e3 * limits.home)
    return [*found, ["mean position", mean, "" if limits.mean_positions else "mm"]]


def _figures(plan: Plan) -> dict[str, Figure]:
    drawn = {"force": _force(plan), "loop": _loop(plan), "drive": _drive(plan)}
    if plan.chances is not None:
        drawn["curve"] = _curve(plan)
    return drawn


def _names(plan: Plan) -> list[str]:
    named = [f"{p.replace('_', ' ')} ({e})" for p, e in zip(plan.phenomena, plan.effects, strict=True)]
    return named or ["model"]


def _force(plan: Plan) -> Figure:
    """Forces over time; the band of noise and model form lies about the first."""
    first = plan.force[0]
    band = [
        line(
            plan.time,
            first + sign * plan.band_n,
            "noise and form",
            GREY,
            0.5,
            showlegend=False,
            hoverinfo="skip",
            **more,
        )
        for sign, more in ((-1.0, {}), (1.0, {"fill": "tonexty", "fillcolor": GREY, "opacity": 0.3}))
    ]
    curves = [
        line(plan.time, force, name, colour, 1.6)
        for force, name, colour in zip(plan.force, _names(plan), COLOURS, strict=False)
    ]
    layout = {"xaxis": axis("time in s"), "yaxis": axis("damper force in N"), "showlegend": True}
    return {"data": [*band, *curves], "layout": layout}


def _loop(plan: Plan) -> Figure:
    curves = [
        line(plan.velocity, force, name, colour, 1.2)
        for force, name, colour in zip(plan.force, _names(plan), COLOURS, strict=False)
    ]
    layout = {"xaxis": axis("velocity in m/s"), "yaxis": axis("damper force in N"), "showlegend": True}
    return {"data": curves, "layout": layout}


def _drive(plan: Plan) -> Figure:
    rows = min_max_rows([plan.displacement], _MOST)
    hover = "%{y:.2f} mm<extra></extra>"
    drawn = line(rows / plan.limits.rate, 1e3 * plan.displacement[rows], "drive", INK, 1.0, hovertemplate=hover)
    return {"data": [drawn], "layout": {"xaxis": axis("time in s"), "yaxis": axis("displacement in mm")}}


def _curve(plan: Plan) -> Figure:
    tied = np.clip(1.0 - plan.curve.right - plan.curve.wrong, 0.0, 1.0)
    hover = "%{x:.2f} min: %{y:.1f} %<extra></extra>"
    curves = [
        {
            "type": "scatter", "mode": "lines+markers", "name": name, "x": short(plan.curve.minutes),
            "y": short(100.0 * values), "line": {"color": colour}, "hovertemplate": hover,
        }
        for name, values, colour in (
            ("right", plan.curve.right, "@model0"), ("wrong", plan.curve.wrong, "@error"),
            ("the tie stays", tied, "@samples"),
        )
    ]  # fmt: skip
    layout = {
        "xaxis": axis("minutes of test", rangemode="tozero"),
        "yaxis": axis("probability in %", range=[-2.0, 102.0]),
        "showlegend": True,
    }
    return {"data": curves, "layout": layout}
