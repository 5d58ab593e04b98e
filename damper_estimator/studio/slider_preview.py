"""The curve that follows a slider: the force of the model with the moved parameters over the visible stretch."""

from collections.abc import Mapping

import numpy as np

from damper_estimator.studio.drawn_rows import span_of
from damper_estimator.studio.model_run import ModelRun
from damper_estimator.studio.view import View

RUN_IN = 2.0  # s before the stretch, until states have settled
MOST = 150_000  # samples that can be run while a slider moves; more wait for its end


def preview_force(shown: ModelRun, values: Mapping[str, float], view: View) -> np.ndarray | None:
    """(n,) N in band, NaN where it was not run; None where the stretch on view is too long for that."""
    trace = shown.traces[view.recording]
    time = trace.time - trace.time[0]
    span = span_of(time, view.start, view.stop)
    first = int(np.searchsorted(time, time[span.start] - RUN_IN))
    last = int(np.searchsorted(time, time[span.stop - 1] + 0.2))
    if last - first > MOST:
        return None
    part = trace.measurement.part(first, max(last, span.stop))
    force = np.full(time.size, np.nan)
    force[first : first + len(part.kinematics)] = part.in_band(
        np.nan_to_num(shown.model.with_values(values).force(part.kinematics.block))
    )
    force[: span.start] = np.nan
    return force
