"""The linked figures: force over time with the residual, and over velocity, displacement and acceleration."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.report.packing import packed
from damper_estimator.report.plots import FOUND, MOTIONS, SOFT, Figure, axis, line, note
from damper_estimator.report.theme import model_colour
from damper_estimator.studio.drawn_rows import cloud_rows, density_rows, line_rows, span_of
from damper_estimator.studio.model_run import Curves, ModelRun
from damper_estimator.studio.view import SCALES, TRACE_NAMES, TRACES, View, marked
from damper_estimator.validation import Trace

_MARKED_POINTS = 1200
LOOP_SAMPLES = 2500  # on view up to which force is drawn as loops
_DARKNESS = (0.25, 0.45, 0.8)
_DOT = np.array([0.009, 0.014])  # of what a cloud reaches over: about three pixels
_BREAK = 1.0 / 400.0  # of the stretch on view: a gap that is longer is left open


@dataclass(frozen=True)
class Scene:
    """Models side by side over one recording.

    Attributes:
        models: those on view; the first one's measured force is drawn.
        names: as they are shown.
        view: what of them is on view.
        further: names of the quantities below the force, keys of ``TRACES``.
        preview: (n,) N in band, the force with the parameters being moved, NaN outside the stretch that was run;
            None if none are moved.
    """

    models: Sequence[ModelRun]
    names: Sequence[str]
    view: View
    preview: np.ndarray | None = None
    further: tuple[str, ...] = ()

    @cached_property
    def span(self) -> slice:
        """The samples on view; what follows is of these."""
        time, view = self._trace(0).time, self.view
        ends = (None, None) if view.start is None or view.stop is None else (time[0] + view.start, time[0] + view.stop)
        return span_of(time, *ends)

    @cached_property
    def measured(self) -> np.ndarray:
        """(n,) N."""
        return self._trace(0).measured[self.span]

    @cached_property
    def marked(self) -> np.ndarray | None:
        """(n,) bool: what is marked; None where nothing is."""
        inside = marked(self.models[0], self.view)
        return None if inside is None else inside[self.span]

    @property
    def backwards(self) -> list[tuple[int, str]]:
        """Index and name of each model, the one that is worked on last: it is drawn over the others."""
        return list(enumerate(self.names))[::-1]

    @property
    def ends(self) -> tuple[float, float]:
        """First and last time on view, s since the first sample of the recording."""
        if self.view.start is not None and self.view.stop is not None:
            return self.view.start, self.view.stop
        return tuple(self.time(np.array([0, -1])).tolist())

    @property
    def gaps(self) -> np.ndarray:
        """(k,) indices of the first samples after gaps of the recording."""
        gaps = self._curves(0).gaps
        return gaps[np.searchsorted(gaps, self.span.start) : np.searchsorted(gaps, self.span.stop)] - self.span.start

    def time(self, rows: np.ndarray) -> np.ndarray:
        """(k,) s since the first sample of the recording, at some of the samples."""
        time = self._trace(0).time
        return time[self.span][rows] - time[0]

    @property
    def whole_time(self) -> np.ndarray:
        """(m,) s since the first sample, of the whole recording."""
        time = self._trace(0).time
        return time - time[0]

    def at_cursors(self) -> list[tuple[str, str, np.ndarray]]:
        """Name, unit and values (m,) over the whole recording of what cursors read."""
        trace = self._trace(0)
        given = [("measured", "N", trace.measured)]
        for i, name in enumerate(self.names):
            curves = self._curves(i)
            given += [(name, "N", curves.modelled), (f"{name} - measured", "N", curves.residual)]
        kinematics = trace.measurement.kinematics
        for name, (unit, factor) in TRACES.items():
            values = getattr(kinematics, name)
            if np.isfinite(values).any():
                given.append((TRACE_NAMES[name], unit, factor * values))
        return given

    def motion(self, name: str) -> np.ndarray:
        """(n,) as it was recorded, in SI; ``SCALES`` and ``TRACES`` have the units of the figures."""
        return getattr(self._trace(0).measurement.kinematics, name)[self.span]

    def modelled(self, index: int) -> np.ndarray:
        """(n,) N, NaN where it is not judged."""
        if index == 0 and self.preview is not None:
            return np.where(self._trace(0).judged[self.span], self.preview[self.span], np.nan)
        return self._curves(index).modelled[self.span]

    def residual(self, index: int) -> np.ndarray:
        """(n,) N, modelled - measured, NaN where it is not judged."""
        if index == 0 and self.preview is not None:
            return self.modelled(0) - self.measured
        return self._curves(index).residual[self.span]

    def _trace(self, index: int) -> Trace:
        return self.models[index].traces[self.view.recording]

    def _curves(self, index: int) -> Curves:
        return self.models[index].curves[self.view.recording]


def time_figure(scene: Scene) -> Figure:
    """Measured and modelled forces, residuals below, and what is marked."""

    def drawn(values: np.ndarray, name: str, colour: str, **more: object) -> Figure:
        x, y = _broken(scene, values, line_rows(values))
        # Single precision would blur the time of a long recording.
        return line(x, y, name, colour, **more) | {"x": packed(x, "f8")}

    data = [drawn(scene.measured, "measured", "@measured", width=2.2)]
    below = []
    for i, name in scene.backwards:
        colour, named = model_colour(i), f"{name} - measured"
        data.append(drawn(scene.modelled(i), name, colour, width=1.3, legendrank=1001 + i))
        below.append(drawn(scene.residual(i), named, colour, width=1.3, yaxis="y2", showlegend=False))
    domains = stacked(len(scene.further))
    for i, name in enumerate(scene.further):
        unit, factor = TRACES[name]
        hover = f"%{{y:.4g}} {unit}<extra>{TRACE_NAMES[name]}</extra>"
        more = {"yaxis": f"y{3 + i}", "showlegend": False, "hovertemplate": hover}
        below.append(drawn(factor * scene.motion(name), TRACE_NAMES[name], "@measured", width=1.3, **more))
    if scene.marked is not None:
        values = np.where(scene.marked, scene.measured, np.nan)
        data.insert(0, drawn(values, "marked", FOUND, width=7.0) | {"opacity": 0.6, "connectgaps": False})
    units = [TRACES[name][0] for name in scene.further]
    named = [
        note(TRACE_NAMES[name], 0.0, domain[1], xanchor="left", yanchor="bottom", font={"color": SOFT})
        for name, domain in zip(scene.further, domains[2:], strict=True)
    ]
    titles = ["force<br>in N", "residual<br>in N", *units]
    axes = {
        f"yaxis{k + 1 if k else ''}": axis(title, domain=domain, fixedrange=True, nticks=6 if k else 0)
        for k, (title, domain) in enumerate(zip(titles, domains, strict=True))
    }
    layout = {
        "xaxis": axis("time in s", anchor=f"y{len(titles)}", range=list(scene.ends)),
        **axes,
        "shapes": [_cursor(time) for time in scene.view.cursors],
        "annotations": [_cursor_name(name, time) for name, time in zip("AB", scene.view.cursors, strict=False)] + named,
        "hovermode": "x",
        "selectdirection": "h",
        "showlegend": True,
        "margin": {"l": 50, "r": 8, "t": 8, "b": 34},
    }
    return {"data": data + below, "layout": layout}


def stacked(further: int) -> list[list[float]]:
    """Domains of the force, the residual and some further quantities, from top to bottom."""
    heights = np.array([5.0, 2.9, *[2.0] * further])
    gaps = 0.07 / (1.0 + 0.35 * further)
    heights *= (1.0 - gaps * (heights.size - 1)) / heights.sum()
    tops = 1.0 - np.concatenate([[0.0], np.cumsum(heights + gaps)[:-1]])
    return [[max(float(top - height), 0.0), float(top)] for top, height in zip(tops, heights, strict=True)]


def _cursor(time: float) -> Figure:
    line_style = {"color": FOUND, "width": 1.5, "dash": "dash"}
    return {"type": "line", "x0": time, "x1": time, "y0": 0, "y1": 1, "yref": "paper", "line": line_style}


def _cursor_name(name: str, time: float) -> Figure:
    return note(f"<b>{name}</b>", time, 1.0, xref="x", xanchor="left", yanchor="top", font={"color": FOUND})


def cloud_figure(scene: Scene, motion: str) -> Figure:
    """Force over one motion in the stretch on view, and what is marked: loops where it is short, else the density."""
    x = SCALES[motion] * scene.motion(motion)
    outline = cloud_rows(x, scene.measured)
    reach = np.array([np.ptp(values[outline]) if outline.size else 0.0 for values in (x, scene.measured)])

    def cloud(force: np.ndarray, rows: np.ndarray, name: str, colour: str, size: float = 1.0) -> Figure:
        return dots(x[rows], force[rows], size * _DOT * reach, name, colour)

    def loop(force: np.ndarray, name: str, colour: str, width: float) -> list[Figure]:
        across, up = (np.insert(values.astype(float), scene.gaps, np.nan) for values in (x, force))
        hover = f"%{{x:.4g}}: %{{y:.4g}} N<extra>{name}</extra>"
        return [line(across, up, name, colour, width=width, hovertemplate=hover)]

    def density(force: np.ndarray, name: str, colour: str, size: float) -> list[Figure]:
        parts = zip(density_rows(x, force), _DARKNESS, strict=True)
        return [cloud(force, rows, name, colour, size) | {"opacity": dark} for rows, dark in parts if rows.size]

    short = x.size <= LOOP_SAMPLES
    data = loop(scene.measured, "measured", "@measured", 2.0) if short else []
    data = data or density(scene.measured, "measured", "@measured", 1.2)
    for i, name in scene.backwards:
        force, colour = scene.modelled(i), model_colour(i)
        data += loop(force, name, colour, 1.3) if short else density(force, name, colour, 1.0)
    if scene.marked is not None:
        chosen = np.flatnonzero(scene.marked)
        chosen = chosen[:: max(chosen.size // _MARKED_POINTS, 1)]
        data.insert(0, cloud(scene.measured, chosen, "marked", FOUND, 3.5))
    layout = {"xaxis": axis(MOTIONS[motion]), "yaxis": axis("force in N"), "margin": {"l": 50, "r": 8, "t": 6, "b": 34}}
    return {"data": data, "layout": layout}


def dots(x: np.ndarray, y: np.ndarray, half: np.ndarray, name: str, colour: str) -> Figure:
    """A cloud of diamonds at (n,), (n,), ``half`` (2,) as wide and as high; in one path, which is fast."""
    across, up = np.array([-1.0, 0.0, 1.0, 0.0, np.nan]), np.array([0.0, -1.0, 0.0, 1.0, np.nan])
    return {
        "type": "scatter",
        "mode": "none",
        "fill": "toself",
        "name": name,
        "x": packed((x[:, None] + half[0] * across).ravel()),
        "y": packed((y[:, None] + half[1] * up).ravel()),
        "fillcolor": colour,
        "opacity": 0.6,
        "hoverinfo": "skip",
    }


def _broken(scene: Scene, values: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, ...]:
    """Time and values at rows, with a NaN where a gap of the recording is wide enough to be seen."""
    x, y = scene.time(rows), values[rows].astype(float)
    if x.size < 2:
        return x, y
    lost = scene.gaps[(scene.gaps > rows[0]) & (scene.gaps <= rows[-1])]
    before, after = scene.time(lost - 1), scene.time(lost)
    wide = after - before > _BREAK * (x[-1] - x[0])
    places = np.searchsorted(rows, lost[wide])
    return np.insert(x, places, 0.5 * (before + after)[wide]), np.insert(y, places, np.nan)
