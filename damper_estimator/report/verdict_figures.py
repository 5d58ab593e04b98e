"""Figures of the verdict: the error before and after, the ranking of explanations, parameters that moved, the steps."""

from collections.abc import Mapping, Sequence
from textwrap import wrap

import numpy as np

from damper_estimator.diagnosis import AtlasRow, EvaluationSummary, Finding, Improvement, Moved, RankedEffect
from damper_estimator.numbers import number
from damper_estimator.report.diagnosis_wording import plain_name, step_name
from damper_estimator.report.plots import AFTER, BEFORE, CARD, FOUND, GREY, INK, SOFT, Figure, axis, note, short

_LOWEST, _HIGHEST = -15.0, 104.0  # %, what of a gain is worth the space
_NOTABLE, _MOST_ROWS = 0.03, 8  # of the squared error; rows of the atlas
_NAME = 28  # characters of a name after which it wraps, on a phone
_ROOM = 1.32  # of the longest bar: the axis, with what the bar reaches behind it
_FILES = 18  # px, of the menu in the corner
_APART = 0.17  # of a row, between the two ways of judging


def error_bars(
    levels: Sequence[tuple[str, float]], floor_n: float, force_n: float, reference_n: float = float("nan")
) -> Figure:
    """Unseen error as bars, the first of them before, with the noise floor and the form-free reference as lines.

    Args:
        levels: (name, N) from top to bottom.
        floor_n, force_n: N; the error is also shown as a share of the force.
        reference_n: N; NaN if it is unknown.
    """
    names, values = [name for name, _ in levels], np.array([value for _, value in levels])
    most = float(np.nanmax([*values, floor_n, reference_n]))
    bars = {
        "type": "bar",
        "orientation": "h",
        "y": names,
        "x": short(values),
        "marker": {"color": [BEFORE, *[AFTER] * (len(levels) - 1)]},
        "hovertemplate": "%{y}: %{x:.4g} N<extra></extra>",
    }
    layout = {
        "xaxis": axis("rms error on unseen data in N", range=[0.0, _ROOM * most], nticks=6),
        "yaxis": axis(autorange="reversed", ticks="", showgrid=False),
        "bargap": 0.35,
        "showlegend": False,
    }
    words = [f"<b>{number(v)} N</b><br>{number(100.0 * v / force_n, 2)} %" for v in values]
    return {
        "data": [bars],
        "layout": layout | _marked(floor_n, reference_n, names, values, words),
        "height": 110 + 42 * len(levels),
        "plain": True,
    }


def _marked(floor_n: float, reference_n: float, names: Sequence[str], ends: np.ndarray, words: Sequence[str]) -> Figure:
    """What the bars reach, and lines at the noise floor (dashed) and at the form-free reference (dotted), with their
    names above the figure. Words cover the lines, which would strike them out.
    """
    lines = [(floor_n, "noise floor", "dash"), (reference_n, "form-free reference", "dot")]
    known = [line for line in lines if np.isfinite(line[0])]
    shapes = [
        {"type": "line", "x0": value, "x1": value, "y0": 0, "y1": 1, "yref": "paper",
         "line": {"color": INK, "width": 1.5, "dash": dash}}
        for value, _, dash in known
    ]  # fmt: skip
    name = note(
        ", ".join(f"{name} {number(value)} N" for value, name, _ in known), 1.0, 1.0, xanchor="right", xshift=-_FILES,
        yanchor="bottom", font={"color": SOFT, "size": 12},
    )  # fmt: skip
    reached = [
        note(text, end, bar, xref="x", yref="y", xanchor="left", xshift=3, bgcolor=CARD, align="left")
        for text, bar, end in zip(words, names, short(ends), strict=True)
    ]
    return {"shapes": shapes, "annotations": [*reached, *([name] if known else [])]}


def atlas_figure(atlas: Sequence[AtlasRow], findings: Sequence[Finding], width: int = _NAME) -> Figure:
    """Share of the squared error on unseen data that depends on each kind of variable, with 5 and 95 % whiskers.

    Args:
        width: characters of a name after which it wraps.
    """
    rows = [row for row in atlas if row.explains > _NOTABLE][:_MOST_ROWS] or list(atlas[:1])
    found = {name for finding in findings for name in (finding.phenomenon, *finding.tied_with)}
    shown = np.array([100.0 * row.explains for row in rows])
    names = ["<br>".join(wrap(row.shows, width)) for row in rows]
    lines = sum(max(name.count("<br>"), 0.6) for name in names)
    bars = {
        "type": "bar",
        "orientation": "h",
        "y": names,
        "x": short(shown, 3),
        "error_x": _whiskers([(row.low, row.explains, row.high) for row in rows]),
        "marker": {"color": [FOUND if found & set(row.phenomena) else GREY for row in rows]},
        "customdata": [", ".join(map(plain_name, row.phenomena)) or "no single effect" for row in rows],
        "hovertemplate": "%{y}: %{x:.3g} %<br>shows: %{customdata}<extra></extra>",
    }
    layout = {
        "xaxis": axis("squared error in %", range=[0.0, _HIGHEST], nticks=6),
        "yaxis": axis(autorange="reversed", ticks="", showgrid=False, automargin=True),
        "bargap": 0.35,
        "showlegend": False,
    }
    return {"data": [bars], "layout": layout, "height": 80 + round(12 * len(rows) + 31 * lines), "plain": True}


def ranked(ranking: Sequence[RankedEffect], findings: Sequence[Finding]) -> list[RankedEffect]:
    """The best candidate of each phenomenon; found ones with those that are tied first, then by rank."""
    best: dict[str, RankedEffect] = {}
    for judged in ranking:
        if judged.kept is not None or judged.refitted is not None:
            best.setdefault(judged.phenomenon, judged)
    for finding in findings:
        for judged in ranking:
            if judged.effect == finding.effect and (judged.kept or judged.refitted):
                best[finding.phenomenon] = judged
    first = [name for finding in findings for name in (finding.phenomenon, *finding.tied_with)]
    order = [name for name in dict.fromkeys([*first, *best]) if name in best]
    return [best[name] for name in order]


def ranking_figure(ranking: Sequence[RankedEffect], findings: Sequence[Finding], note_of: Mapping[str, str]) -> Figure:
    """Gain on unseen data by phenomenon, with 5 and 95 % whiskers: kept full circles, refitted open diamonds.

    Args:
        note_of: further lines of the hover by effect.
    """
    rows = ranked(ranking, findings)
    found = {finding.phenomenon for finding in findings}
    tied = {name for finding in findings for name in finding.tied_with}

    def colour(judged: RankedEffect) -> str:
        return FOUND if judged.phenomenon in found else INK if judged.phenomenon in tied else GREY

    data = [
        _gains(way, name, symbol, shift, rows, colour, note_of)
        for way, name, symbol, shift in (
            ("kept", "parameters kept", "circle", -_APART),
            ("refitted", "refitted together", "diamond-open", _APART),
        )
        if any(getattr(judged, way) is not None for judged in rows)
    ]
    names = [_emphasised(judged, found, tied) for judged in rows]
    layout = {
        "xaxis": axis("explained squared error in %", range=[_LOWEST, _HIGHEST], nticks=8),
        "yaxis": axis(tickvals=list(range(len(rows))), ticktext=names, range=[len(rows) - 0.4, -0.6], zeroline=False),
        "showlegend": True,
        "margin": {"l": 50, "r": 46, "t": 24, "b": 40},
        **_brackets(rows, findings),
    }
    return {"data": data, "layout": layout, "height": 110 + 21 * len(rows), "plain": True}


def _emphasised(judged: RankedEffect, found: set[str], tied: set[str]) -> str:
    name = plain_name(judged.phenomenon)
    return f"<b>{name}</b>" if judged.phenomenon in found else name if judged.phenomenon in tied else f"<i>{name}</i>"


def _gains(way: str, name: str, symbol: str, shift: float, rows, colour, note_of: Mapping[str, str]) -> Figure:
    """One way of judging: a mark and its whisker per row that was judged so."""
    judged = [
        (i + shift, effect, getattr(effect, way)) for i, effect in enumerate(rows) if getattr(effect, way) is not None
    ]
    gain = np.array([100.0 * way.gain for _, _, way in judged])
    paint = [colour(effect) for _, effect, _ in judged]
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": short(np.clip(gain, _LOWEST + 1.0, _HIGHEST), 3),
        "y": [y for y, _, _ in judged],
        "error_x": _whiskers([(way.low, way.gain, way.high) for *_, way in judged]),
        "marker": {"symbol": symbol, "size": 9, "color": paint, "line": {"width": 2, "color": paint}},
        "text": [_hover(effect, way, note_of.get(effect.effect, "")) for _, effect, way in judged],
        "hovertemplate": "%{text}<extra></extra>",
    }


def _whiskers(ends: Sequence[tuple[float, float, float]]) -> Figure:
    """From shares (low, value, high) to whiskers in %."""
    return {
        "type": "data",
        "symmetric": False,
        "array": short([100.0 * max(high - value, 0.0) for _, value, high in ends], 3),
        "arrayminus": short([100.0 * max(value - low, 0.0) for low, value, _ in ends], 3),
        "color": SOFT,
        "thickness": 1.3,
        "width": 3,
    }


def _hover(judged: RankedEffect, way: EvaluationSummary, more: str) -> str:
    lines = [
        f"<b>{plain_name(judged.phenomenon)}</b> by {judged.effect}",
        f"explains {100.0 * way.gain:z.0f} % ({100.0 * way.low:z.0f} to {100.0 * way.high:z.0f} %), "
        f"{number(way.rmse_n)} N left",
        judged.reason or "found",
        more,
    ]
    return "<br>".join(text for text in lines if text)


def _brackets(rows: Sequence[RankedEffect], findings: Sequence[Finding]) -> Figure:
    """A bracket at the right of each group that these data cannot distinguish."""
    place = {judged.phenomenon: i for i, judged in enumerate(rows)}
    shapes, words = [], []
    for finding in findings:
        group = [place[name] for name in (finding.phenomenon, *finding.tied_with) if name in place]
        if len(group) < 2:
            continue
        top, bottom = min(group) - 0.35, max(group) + 0.35
        corners = f"M 1.005 {top} L 1.02 {top} L 1.02 {bottom} L 1.005 {bottom}"
        shapes.append({"type": "path", "path": corners, "xref": "paper", "line": {"color": INK, "width": 1.5}})
        words.append(
            note("tied", 1.03, (top + bottom) / 2.0, yref="y", xanchor="left", font={"color": INK}, textangle=90)
        )
    return {"shapes": shapes, "annotations": words}


def moved_figure(moved: Sequence[Moved]) -> Figure:
    """Change of each parameter that moved, relative to what it was, with its standard error."""
    size = [abs(parameter.before) or abs(parameter.after) or 1.0 for parameter in moved]
    change = [100.0 * (parameter.after - parameter.before) / s for parameter, s in zip(moved, size, strict=True)]
    bars = {
        "type": "bar",
        "orientation": "h",
        "y": [parameter.name for parameter in moved],
        "x": short(change, 3),
        "marker": {"color": AFTER},
        "error_x": {
            "type": "data",
            "array": short([100.0 * parameter.standard_error / s for parameter, s in zip(moved, size, strict=True)], 3),
            "color": INK,
            "thickness": 1.3,
        },
        "hovertemplate": "%{y}: %{x:+.3g} %<extra></extra>",
    }
    layout = {
        "xaxis": axis("change of the parameter in % of what it was (whisker: standard error)"),
        "yaxis": axis(autorange="reversed"),
        "showlegend": False,
    }
    return {"data": [bars], "layout": layout, "height": 90 + 26 * len(moved), "plain": True}


def waterfall_figure(found: Improvement) -> Figure:
    """Unseen error over the steps: what each took away, down to what is left and the noise floor."""
    steps, floor = found.steps, found.noise_floor_n
    errors = np.array([step.rmse_unseen_n for step in steps])
    names = [step_name(step) for step in steps] + ["<b>improved model</b>"]
    low = np.concatenate([[0.0], np.minimum(errors[:-1], errors[1:]), [0.0]])
    high = np.concatenate([errors[:1], np.maximum(errors[:-1], errors[1:]), errors[-1:]])
    change = np.concatenate([[0.0], np.diff(errors)])
    paint = [BEFORE, *[FOUND if c <= 0.0 else BEFORE for c in change[1:]], AFTER]
    words = [f"<b>{number(errors[0])} N</b>", *[_changed(c) for c in change[1:]], f"<b>{number(errors[-1])} N</b>"]
    bars = {
        "type": "bar",
        "orientation": "h",
        "y": names,
        "base": short(low),
        "x": short(high - low),
        "marker": {"color": paint},
        "customdata": short([*errors, errors[-1]]),
        "hovertemplate": "%{y}: %{customdata:.4g} N on unseen data<extra></extra>",
    }
    most = float(np.nanmax([*errors, found.reference_n]))
    layout = {
        "xaxis": axis("rms error on unseen data in N", range=[0.0, _ROOM * most]),
        "yaxis": axis(autorange="reversed", showgrid=False),
        "bargap": 0.3,
        **_marked(floor, found.reference_n, names, high, words),
    }
    return {"data": [bars], "layout": layout, "height": 120 + 34 * len(names), "plain": True}


def _changed(change: float) -> str:
    return "no change" if not change else f"{'−' if change < 0.0 else '+'}{number(abs(change))} N"
