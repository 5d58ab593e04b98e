"""What an effect would explain: the residual on unseen data before and after."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.diagnosis import Diagnosis
from damper_estimator.report.plots import AFTER, BEFORE, Figure, axis, line, note
from damper_estimator.studio.drawn_rows import line_rows
from damper_estimator.validation.trace import trace

_SECONDS = 2.0  # that are shown, about the worst moment


def explained_figure(found: Diagnosis, effect: str) -> Figure:
    """The residual of the diagnosed model in its worst seconds, and what the effect would leave of it."""
    change = next((ranked.explains for ranked in found.ranking if ranked.effect == effect), ())
    traces = [trace(found.model, m) for m in found.unseen]
    before = [np.where(t.judged, t.residual, np.nan) for t in traces]
    index, span = _worst([t.time for t in traces], before)
    worst, time = traces[index], traces[index].time
    rows = span.start + line_rows(before[index][span], 1200)
    data = [line(time[rows], before[index][rows], "residual now", BEFORE)]
    notes = []
    if index < len(change) and change[index].size == time.size:
        data.append(line(time[rows], (before[index] + change[index])[rows], "with this effect", AFTER))
    else:
        notes = [note("it explains next to nothing", 0.5, 0.95)]
    where = worst.measurement.recording.rpartition("/")[2]
    layout = {
        "xaxis": axis(f"time in s ({where}, unseen)"),
        "yaxis": axis("model - measured in N"),
        "showlegend": True,
        "annotations": notes,
    }
    return {"data": data, "layout": layout}


def _worst(times: Sequence[np.ndarray], errors: Sequence[np.ndarray]) -> tuple[int, slice]:
    """Index of the recording and the seconds in it that carry the most squared error."""
    best = (-1.0, 0, slice(0, 1))
    for i, (time, error) in enumerate(zip(times, errors, strict=True)):
        total = np.concatenate([[0.0], np.cumsum(np.nan_to_num(error) ** 2)])
        ends = np.searchsorted(time, time + _SECONDS)
        first = int(np.argmax(total[ends] - total[:-1]))
        carried = float(total[ends[first]] - total[first])
        if carried > best[0]:
            best = (carried, i, slice(first, int(ends[first])))
    return best[1], best[2]
