"""The page of a fleet: errors over time, temperature, vehicle and damper; drifts; missing phenomena; every recording.

Rows are plain mappings as ``fleet`` keeps them. The page sorts, filters and draws by itself; a click on a point or a
row opens the recording's own report.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from urllib.parse import quote

import numpy as np

from damper_estimator.report.page import render
from damper_estimator.report.plots import TIGHT, Figure, axis, short

MOST = 20_000  # rows in the page, about 5 MB
_FAR = 3.5  # robust standard deviations from the damper's own median: an outlier
_MEASURES = {
    "nrmse": "rms error over rms force (1)",
    "rmse_n": "rms error (N)",
    "bias_n": "mean error (N)",
    "peak_error_n": "largest error (N)",
    "esr": "error-to-signal ratio (1)",
    "noise_floor_n": "noise floor (N)",
    "residual_rms_n": "rms residual, not in band (N)",
    "force_rms_n": "rms force (N)",
    "seconds": "length (s)",
}
_FIRST = {"replay": "residual_rms_n", "compare": "nrmse"}  # what is shown first; elsewhere the error


def fleet_page(
    rows: Mapping[str, Sequence[Mapping[str, object]]],
    trends: Sequence[Mapping[str, object]],
    judged: int,
    rule: str,
) -> str:
    """The whole page as HTML; it is self-contained and needs no network.

    Args:
        rows: by verb, sorted by recording and damper.
        trends: of dampers that drift away, as ``fleet.trend.Trend`` has them, of ``judged`` that could be judged.
        rule: by which they are named, in words.
    """
    shown = {verb: _shown(results) for verb, results in rows.items()}
    data = {
        "verbs": {verb: _columns(results, verb) for verb, results in shown.items()},
        "measures": _MEASURES,
        "figures": _figures(),
        "first": {verb: _FIRST.get(verb, "rmse_n") for verb in shown},
    }
    text = {
        "damper": "fleet",
        "headline": _headline(rows, trends, judged),
        "trends": [_trend_row(trend) for trend in trends],
        "judged": judged,
        "rule": rule,
        "verbs": list(shown),
        "cut": [
            f"{verb}: {len(shown[verb])} of {len(results)}" for verb, results in rows.items() if len(results) > MOST
        ],
        "diagnosed": "diagnose" in shown,
    }
    return render("fleet.html", "fleet", [text], ["page.css", "fleet.css"], "fleet.js", data)


def _figures() -> dict[str, Figure]:
    """The figures without rows; the page's script puts in those on view and the chosen quantity."""

    def marks(colour: str, size: int, symbol: str) -> Figure:
        marker = {"color": colour, "size": size, "symbol": symbol, "opacity": 0.75}
        return {"mode": "markers", "marker": marker, "hovertemplate": "%{text}<br>%{y:.4g}<extra></extra>"}

    def bars(fill: str) -> Figure:
        marker = {"color": fill, "line": {"color": "@model0", "width": 1.5}}
        return {"type": "bar", "orientation": "h", "marker": marker, "hovertemplate": "%{y}: %{x:.3g} %<extra></extra>"}

    def layout(x: Figure) -> Figure:
        return {"xaxis": x, "yaxis": axis(rangemode="tozero"), "margin": TIGHT}

    clear = "rgba(0,0,0,0)"
    clouds = [marks("@model0", 5, "circle"), marks("@error", 9, "diamond")]
    box = {"type": "box", "boxpoints": False, "line": {"color": "@model0", "width": 1.4}, "fillcolor": clear}
    share = layout(axis("share of the diagnosed recordings in %")) | {"barmode": "overlay"}
    return {
        "time": {"data": clouds, "layout": layout(axis(type="date"))},
        "temperature": {"data": clouds, "layout": layout(axis("temperature in °C"))},
        "boxes": {"data": [box], "layout": layout(axis(type="category"))},
        "missing": {"data": [bars(clear), bars("@model0")], "layout": share},
    }


def _shown(rows: Sequence[Mapping[str, object]]) -> list[Mapping[str, object]]:
    """All rows; of too many those that failed or lie far out, and an even choice of the others."""
    if len(rows) <= MOST:
        return list(rows)
    far = _far(rows)
    special = [i for i, row in enumerate(rows) if row["status"] != "done" or far[i]][: MOST // 2]
    even = np.linspace(0, len(rows) - 1, MOST - len(special)).astype(int).tolist()
    return [rows[i] for i in sorted({*special, *even})]


def _error(row: Mapping[str, object]) -> float:
    value = next((row[name] for name in ("nrmse", "rmse_n", "residual_rms_n") if row[name] is not None), None)
    return float(np.log(value)) if value else float("nan")


def _far(rows: Sequence[Mapping[str, object]]) -> list[bool]:
    """Whether a row's error lies far above those of the same damper and vehicle, by median and median deviation."""
    errors = np.array([_error(row) for row in rows])
    groups: dict[tuple, list[int]] = {}
    for i, row in enumerate(rows):
        if np.isfinite(errors[i]) and not row["spoiled"]:
            groups.setdefault((row["vehicle"], row["damper"]), []).append(i)
    # A damper with few recordings is held against all of its name.
    pools: dict[object, list[int]] = {}
    for (vehicle, damper), pool in groups.items():
        pools.setdefault((vehicle, damper) if len(pool) >= 8 else damper, []).extend(pool)
    far = np.zeros(len(rows), bool)
    for pool in pools.values():
        off = errors[pool] - np.median(errors[pool])
        spread = max(1.4826 * float(np.median(np.abs(off))), 0.02)
        far[pool] = off > _FAR * spread
    return far.tolist()


def _columns(rows: Sequence[Mapping[str, object]], verb: str) -> dict[str, object]:
    """The rows as the page's script reads them: one list per column, names once."""
    measures = {name: [_number(row[name]) for row in rows] for name in _MEASURES}
    return {
        "recording": [Path(str(row["recording"])).stem for row in rows],
        "link": [quote(row["report"] or "") for row in rows],
        "vehicle": _coded([row["vehicle"] for row in rows]),
        "damper": _coded([row["damper"] for row in rows]),
        "begin": [None if row["begin"] is None else row["begin"] // 1_000_000 for row in rows],
        "temperature": short([np.nan if row["temperature_c"] is None else row["temperature_c"] for row in rows]),
        "reason": [row["reason"] for row in rows],
        "data": [row["data_findings"] or [] for row in rows],
        "spoiled": [bool(row["spoiled"]) for row in rows],
        "verdict": [row["verdict"] for row in rows] if verb == "diagnose" else [],
        "missing": [row["missing"] or [] for row in rows] if verb == "diagnose" else [],
        "far": _far(rows),
        "measures": {name: values for name, values in measures.items() if any(value is not None for value in values)},
    }


def _number(value: object) -> float | None:
    return None if value is None else float(f"{value:.4g}")


def _coded(names: Sequence[object]) -> dict[str, list]:
    """Names once, and for each row which."""
    order = {name: i for i, name in enumerate(sorted(set(names)))}
    return {"names": list(order), "of": [order[name] for name in names]}


def _headline(rows: Mapping[str, Sequence[Mapping]], trends: Sequence[Mapping], judged: int) -> str:
    every = [row for results in rows.values() for row in results]
    recordings = len({row["recording"] for row in every})
    vehicles = len({row["vehicle"] for row in every})
    words = [f"{recordings} recordings of {vehicles} vehicle{'s' if vehicles != 1 else ''}."]
    errors = [row["nrmse"] for row in rows.get("compare", ()) if row["nrmse"] is not None and not row["spoiled"]]
    if errors:
        words.append(
            f"The model's error is {100 * float(np.median(errors)):.3g} % of the force in the median recording."
        )
        words.append(
            f"{len(trends)} of {judged} dampers drift away from it."
            if judged
            else "No damper has enough recordings to detect a drift."
        )
    found = Counter(name for row in rows.get("diagnose", ()) for name in row["missing"] or ())
    if found:
        name, count = found.most_common(1)[0]
        words.append(f"Most often missing: {name.replace('_', ' ')}, {count} times.")
    failed = sum(row["status"] != "done" for row in every)
    spoiled = len({row["recording"] for row in every if row["spoiled"]})
    if spoiled:
        some, are = ("recordings", "are") if spoiled > 1 else ("recording", "is")
        words.append(f"{spoiled} {some} with a faulty channel {are} left out of all figures: see the column data.")
    return " ".join(words + ([f"{failed} tasks failed."] if failed else []))


def _trend_row(trend: Mapping[str, object]) -> dict[str, object]:
    return {
        "vehicle": trend["vehicle"],
        "damper": trend["damper"],
        "cells": [
            f"{_day(trend['since_ns'])}",
            f"{_day(trend['low_ns'])} to {_day(trend['high_ns'])}",
            f"× {trend['growth']:.3g}",
            f"{trend['p']:.2g}",
            f"{trend['recordings']}",
        ],
    }


def _day(stamp: object) -> str:
    return datetime.fromtimestamp(int(stamp) / 1e9, UTC).date().isoformat()
