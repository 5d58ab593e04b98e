"""The figure of what a diagnosis used of long recordings."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.diagnosis import Diagnosis
from damper_estimator.report.plots import AFTER, FOUND, GREY, Figure, axis, short
from damper_estimator.report.wording import recording_name


def stretches_figure(diagnosis: Diagnosis) -> Figure:
    """What of long recordings was used: a bar per recording over time, with the stretches of both uses on it."""
    whole = [*diagnosis.fit, *diagnosis.unseen]
    ends = [(m.kinematics.time[0] / 60.0, m.kinematics.time[-1] / 60.0) for m in whole]
    data = [_spans("recorded", GREY, [(recording_name(m.recording), *end) for m, end in zip(whole, ends, strict=True)])]
    for use, name, colour in (("fit", "effects fitted to", AFTER), ("unseen", "effects judged on", FOUND)):
        used = [one for one in diagnosis.stretches if one.use == use]
        data.append(
            _spans(name, colour, [(recording_name(one.recording), one.start / 60.0, one.stop / 60.0) for one in used])
        )
    layout = {
        "xaxis": axis("time in min", range=[0.0, max(end for _, end in ends)]),
        "yaxis": axis(ticks="", showgrid=False, automargin=True),
        "barmode": "overlay",
        "bargap": 0.4,
        "showlegend": True,
        "margin": {"l": 50, "r": 12, "t": 24, "b": 40},
    }
    return {"data": data, "layout": layout, "height": 120 + 30 * len({m.recording for m in whole}), "plain": True}


def _spans(name: str, colour: str, spans: Sequence[tuple[str, float, float]]) -> Figure:
    """Horizontal bars from one time to another, in minutes."""
    return {
        "type": "bar",
        "orientation": "h",
        "name": name,
        "y": [recording for recording, _, _ in spans],
        "base": short(np.array([start for _, start, _ in spans])),
        "x": short(np.array([stop - start for _, start, stop in spans])),
        "marker": {"color": colour, "line": {"width": 0}},
        "hovertemplate": "from %{base:.2f} min, %{x:.2f} min long<extra>" + name + "</extra>",
    }
