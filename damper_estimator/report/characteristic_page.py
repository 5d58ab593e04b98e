"""The page of ``characterize``: loops with points A to H, the types by band and the structure they call for."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.characterization import MEANINGS, Characterization, Diagram
from damper_estimator.characterization.serialization import peaks
from damper_estimator.numbers import number
from damper_estimator.report.packing import packed
from damper_estimator.report.page import render
from damper_estimator.report.plots import GREY, INK, MOTIONS, TIGHT, Figure, axis, line
from damper_estimator.report.theme import model_colour
from damper_estimator.report.wording import recording_name

_ROLES = {
    "total": "total force", "semi_active": "semi-active part", "command": "command's part", "pressure": "pressure part",
    "setting": "other setting's part",
}  # fmt: skip


def characteristic_page(found: Sequence[Characterization]) -> str:
    """The whole page as HTML; it is self-contained and needs no network."""
    return render(
        "characteristics.html",
        f"characteristic diagrams of {', '.join(c.damper for c in found)}",
        [_section(c) for c in found],
        ["page.css", "characteristics.css"],
        "characteristics.js",
        {
            "sections": [[_figure(d) for d in (*c.diagrams, *c.differences)] for c in found],
            "styles": _styles(),
            "axes": {
                motion: {"xaxis": axis(title), "yaxis": axis("force in N"), "margin": TIGHT}
                for motion, title in MOTIONS.items()
            },
        },
    )


def _styles() -> dict[str, Figure]:
    """Traces without samples: a pale loop of a steady or of a single cycle, the chosen loop, and its points."""

    def loop(colour: str, width: float, hover: str, **more: object) -> Figure:
        line = {"color": colour, "width": width} | more
        hover += "<extra>%{fullData.name}</extra>"
        return {"type": "scatter", "mode": "lines", "line": line, "hovertemplate": hover}

    return {
        "steady": loop(GREY, 1, "%{y:.0f} N") | {"opacity": 0.55},
        "single": loop(GREY, 1, "%{y:.0f} N", dash="dot") | {"opacity": 0.55},
        "chosen": loop("@model0", 2.5, "%{x:.4g}, %{y:.0f} N"),
        "points": {
            "type": "scatter",
            "mode": "markers+text",
            "textfont": {"size": 14, "color": INK},
            "marker": {"size": 9, "color": "@model1"},
            "hovertemplate": "%{text}: %{x:.4g}, %{y:.0f} N<extra></extra>",
        },
    }


def _figure(diagram: Diagram) -> dict[str, object]:
    """One loop, closed, for the script."""
    loop = diagram.loop

    def closed(values: np.ndarray) -> dict[str, str]:
        return packed(np.append(values, values[0]))

    points = diagram.points.values()
    return {
        "name": _name(diagram),
        "role": diagram.role,
        "level": float(np.nan_to_num(loop.command)),
        "steady": loop.steady,
        "force": closed(loop.force),
        "motion": {
            "displacement": closed(1e3 * loop.displacement),
            "velocity": closed(loop.velocity),
            "acceleration": closed(loop.acceleration),
        },
        "points": {
            "name": [p.name for p in points],
            "textposition": ["middle left" if p.name in "CGDH" else "middle right" for p in points],
            "force": [p.force for p in points],
            "displacement": [1e3 * p.displacement for p in points],
            "velocity": [p.velocity for p in points],
            "acceleration": [p.acceleration for p in points],
        },
    }


def _name(diagram: Diagram) -> str:
    loop = diagram.loop
    command = "" if np.isnan(loop.command) else f", command {loop.command:.3g}"
    less = "" if np.isnan(diagram.subtrahend) else f" less {diagram.subtrahend:.3g}"
    return f"{loop.frequency:.3g} Hz, {1e3 * loop.amplitude:.3g} mm{command}{less}"


def _section(found: Characterization) -> dict[str, object]:
    diagrams = (*found.diagrams, *found.differences)
    return {
        "damper": found.damper,
        "headline": _headline(found),
        "structure": found.structure,
        "notes": found.notes,
        "bands": found.bands,
        "roles": [(role, _ROLES[role]) for role in dict.fromkeys(d.role for d in diagrams)],
        "rows": [_row(index, d) for index, d in enumerate(diagrams)],
        "details": [_details(d) for d in diagrams],
        "recordings": ", ".join(recording_name(path) for path in found.recordings),
    }


def _headline(found: Characterization) -> str:
    passive = [f"{b.passive} at {b.low:g} to {b.high:g} Hz" for b in found.bands if b.passive is not None]
    active = [f"{b.semi_active} at {b.low:g} to {b.high:g} Hz" for b in found.bands if b.semi_active is not None]
    if found.structure is None:
        return "has no diagram between 0.5 and 15 Hz, so it has no type."
    text = f"is of pattern type {', '.join(passive)}"
    if active:
        text += f"; its semi-active part of type {', '.join(active)}"
    return f"{text}. Fit {found.structure.library_name}."


def _row(index: int, diagram: Diagram) -> dict[str, object]:
    row, p = peaks(diagram.loop), diagram.pattern
    return {
        "index": index,
        "role": diagram.role,
        "cells": [
            _ROLES[diagram.role],
            _name(diagram),
            f"{diagram.loop.cycles}{'' if diagram.loop.steady else ' single'}",
            f"{row['peak_velocity_rebound_m_s']:.4f}",
            f"{row['force_rebound_n']:.0f}",
            f"{row['peak_velocity_compression_m_s']:.4f}",
            f"{row['force_compression_n']:.0f}",
            f"{p.type}",
            f"{100 * p.hysteresis_low:+.1f} / {100 * p.hysteresis_high:+.1f}",
            f"{_knee(p.rebound)} / {_knee(p.compression)}",
            "yes" if p.symmetric else "no",
        ],
    }


def _knee(half) -> str:
    return number(half.knee_velocity) if half.yields else "none"


def _details(diagram: Diagram) -> dict[str, object]:
    points = [
        [
            p.name,
            MEANINGS[p.name],
            f"{1e3 * p.displacement:.2f}",
            f"{p.velocity:.4f}",
            f"{p.acceleration:.3g}",
            f"{p.force:.0f}",
        ]
        + [number(value) for value in (line.stiffness / 1e3, line.damping, line.mass)]
        for p, line in zip(diagram.points.values(), diagram.lines.values(), strict=True)
    ]
    return {"name": _name(diagram), "type": diagram.pattern.type, "because": diagram.pattern.because, "points": points}


def loops_over_velocity(diagrams: Sequence[Diagram]) -> dict[str, object]:
    """Force over velocity of each operating point, for notebooks."""
    data = [
        line(np.append(d.loop.velocity, d.loop.velocity[0]), np.append(d.loop.force, d.loop.force[0]), _name(d),
             model_colour(number))
        for number, d in enumerate(diagrams)
    ]  # fmt: skip
    return {"data": data, "layout": {"xaxis": axis("velocity in m/s"), "yaxis": axis("force in N"), "showlegend": True}}
