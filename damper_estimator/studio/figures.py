"""The linked figures: force over time with the residual, and over velocity, displacement and acceleration."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.report.figures import packed
from damper_estimator.report.plots import FOUND, Figure, axis, line, points
from damper_estimator.studio.rows import cloud_rows, line_rows, span_of
from damper_estimator.studio.shown import Shown
from damper_estimator.studio.view import MOTIONS, View, marked, place

TITLES = {
    "velocity": "velocity in m/s", "displacement": "displacement in mm", "acceleration": "acceleration in m/s²",
}  # fmt: skip
_MARKED_POINTS = 1200
_BREAK = 1.0 / 400.0  # of the stretch on view: a gap that is longer is left open


@dataclass(frozen=True)
class Scene:
    """Models side by side over one recording.

    Attributes:
        models: those on view; the first one's measured force is drawn.
        names: as they are shown.
        view: what of them is on view.
        tried: (n,) N in band, the force with parameters that are being moved, NaN outside of the stretch that was run;
            None where none are.
    """

    models: Sequence[Shown]
    names: Sequence[str]
    view: View
    tried: np.ndarray | None = None

    @property
    def time(self) -> np.ndarray:
        """(n,) s since the first sample of the recording."""
        own = self.models[0].traces[self.view.recording].time
        return own - own[0]

    @property
    def span(self) -> slice:
        """The samples on view."""
        return span_of(self.time, self.view.start, self.view.stop)

    @property
    def measured(self) -> np.ndarray:
        """(n,) N."""
        return self.models[0].traces[self.view.recording].measured

    @property
    def backwards(self) -> list[tuple[int, str]]:
        """Index and name of each model, the one that is worked on last: it is drawn over the others."""
        return list(enumerate(self.names))[::-1]

    def modelled(self, index: int) -> np.ndarray:
        """(n,) N, NaN where it is not judged."""
        own = self.models[index].traces[self.view.recording]
        if index == 0 and self.tried is not None:
            return np.where(own.judged, self.tried, np.nan)
        return np.where(own.judged, own.modelled, np.nan)


def time_figure(scene: Scene) -> Figure:
    """Measured and modelled forces, residuals below, and what is marked."""
    time, span = scene.time, scene.span
    starts = np.flatnonzero(scene.models[0].traces[scene.view.recording].measurement.kinematics.dt <= 0.0)

    def drawn(values: np.ndarray, name: str, colour: str, **more: object) -> Figure:
        x, y = _broken(time, values, line_rows(values, span), starts)
        # Single precision would blur the time of a long recording.
        return line(x, y, name, colour, **more) | {"x": packed(x, "f8")}

    data = [drawn(scene.measured, "measured", "@measured", width=2.2)]
    below = []
    for i, name in scene.backwards:
        values = scene.modelled(i)
        data.append(drawn(values, name, f"@model{i % 5}", width=1.3, legendrank=1001 + i))
        residual = values - scene.models[i].traces[scene.view.recording].measured
        below.append(drawn(residual, f"{name} - measured", f"@model{i % 5}", width=1.3, yaxis="y2", showlegend=False))
    inside = marked(scene.models[0], scene.view)
    if inside is not None:
        values = np.where(inside, scene.measured, np.nan)
        data.insert(0, drawn(values, "marked", FOUND, width=7.0) | {"opacity": 0.6, "connectgaps": False})
    ends = [scene.view.start, scene.view.stop] if scene.view.start is not None else [float(time[0]), float(time[-1])]
    layout = {
        "xaxis": axis("time in s", anchor="y2", range=ends),
        "yaxis": axis("force in N", domain=[0.41, 1.0], fixedrange=True),
        "yaxis2": axis("residual<br>in N", domain=[0.0, 0.34], fixedrange=True),
        "hovermode": "x",
        "selectdirection": "h",
        "showlegend": True,
        "margin": {"l": 50, "r": 8, "t": 8, "b": 34},
    }
    return {"data": data + below, "layout": layout}


def cloud_figure(scene: Scene, motion: str) -> Figure:
    """Force over one motion in the stretch on view, and what is marked."""
    first, span = scene.models[0], scene.span
    x = place(first, scene.view.recording, motion)
    rows = cloud_rows(x, scene.measured, span)
    data = [points(x[rows], scene.measured[rows], "measured", "@measured", 3.0)]
    for i, name in scene.backwards:
        values = scene.modelled(i)
        data.append(points(x[rows], values[rows], name, f"@model{i % 5}", 2.6))
    inside = marked(first, scene.view)
    if inside is not None:
        chosen = np.flatnonzero(inside[span]) + span.start
        chosen = chosen[:: max(chosen.size // _MARKED_POINTS, 1)]
        data.insert(0, points(x[chosen], scene.measured[chosen], "marked", FOUND, 9.0) | {"opacity": 0.6})
    layout = {"xaxis": axis(TITLES[motion]), "yaxis": axis("force in N"), "margin": {"l": 50, "r": 8, "t": 6, "b": 34}}
    return {"data": data, "layout": layout}


def figures(scene: Scene) -> dict[str, Figure]:
    """All linked figures by name."""
    return {"time": time_figure(scene)} | {motion: cloud_figure(scene, motion) for motion in MOTIONS}


def _broken(time: np.ndarray, values: np.ndarray, rows: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, ...]:
    """Time and values at rows, with a NaN where a gap of the recording is wide enough to be seen."""
    x, y = time[rows], values[rows].astype(float)
    if x.size < 2:
        return x, y
    lost = starts[(starts > rows[0]) & (starts <= rows[-1])]
    lost = lost[time[lost] - time[lost - 1] > _BREAK * (x[-1] - x[0])]
    places = np.searchsorted(rows, lost)
    return np.insert(x, places, 0.5 * (time[lost] + time[lost - 1])), np.insert(y, places, np.nan)
