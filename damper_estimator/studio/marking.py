"""What a marked region is good for: the samples in it as stretches of time, as a case of its own, as a table."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.numbers import number
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, PRESSURE, TEMPERATURE
from damper_estimator.studio.model_run import ModelRun
from damper_estimator.studio.slider_preview import RUN_IN
from damper_estimator.studio.stage import MOST_JUDGED, Stretch
from damper_estimator.studio.view import View, marked

MOST_ROWS = 400_000  # of a table that a browser is given
_SHARE = 0.6  # of the marked samples that parameters are found on where a region is diagnosed
_SLOW = {"command_a": COMMAND, "temperature_degc": TEMPERATURE, "pressure_pa": PRESSURE}


def inside_of(shown: ModelRun, view: View) -> np.ndarray:
    """(n,) bool: the marked samples of the recording on view.

    Raises:
        InputError: where nothing is marked.
    """
    inside = marked(shown, view)
    if inside is None or not inside.any():
        raise InputError("mark a region first: choose mark or lasso, then drag in a figure")
    return inside


def stretches(shown: ModelRun, view: View) -> tuple[Stretch, ...]:
    """The marked samples as stretches of time; single samples that were not marked between others count as marked."""
    inside = inside_of(shown, view)
    time = shown.traces[view.recording].time
    rows = np.flatnonzero(inside)
    parts = np.split(rows, np.flatnonzero(np.diff(rows) > 2) + 1)
    step = float(np.median(np.diff(time))) if time.size > 1 else 0.0
    seconds = [(float(time[part[0]] - time[0]), float(time[part[-1]] - time[0])) for part in parts]
    return tuple((view.recording, first - 0.4 * step, last + 0.4 * step) for first, last in seconds)


def in_words(shown: ModelRun, view: View) -> str:
    """How much is marked of which recording, such as ``2.4 s of run.mcap``."""
    inside = inside_of(shown, view)
    dt = shown.traces[view.recording].measurement.kinematics.dt
    return f"{dt[inside].sum():.3g} s of {shown.stage.names[view.recording]}"


def errors_in_words(shown: ModelRun, view: View, name: str) -> str:
    """The rms error of a model on what is marked, and on the rest of the recording."""
    inside = inside_of(shown, view)
    trace = shown.traces[view.recording]
    there, elsewhere = (_rms(trace.residual[part & trace.judged]) for part in (inside, ~inside))
    return (
        f"marked: {in_words(shown, view)}, {int(inside.sum())} samples; rms error of {name} there {there}, "
        f"elsewhere in the recording {elsewhere}"
    )


def marked_alone(shown: ModelRun, view: View) -> Measurement:
    """The recording on view with nothing but the marked samples judged, and what the model needs before them.

    Raises:
        InputError: where nothing of it can be judged, or it is too long.
    """
    inside = inside_of(shown, view)
    measurement = shown.traces[view.recording].measurement
    rows = np.flatnonzero(inside & measurement.judged)
    if rows.size < 3:
        raise InputError("none of the marked samples can be judged; mark more")
    time = measurement.kinematics.time
    first = int(np.searchsorted(time, time[rows[0]] - RUN_IN))
    last = int(rows[-1]) + 1
    if last - first > MOST_JUDGED:
        raise InputError(f"the marked region spans more than {MOST_JUDGED} samples; mark less")
    return replace(measurement, judged=measurement.judged & inside).part(first, last)


def parted(measurement: Measurement) -> tuple[Measurement, Measurement]:
    """The judged samples in two: the first 60 % to find parameters on, the others to judge on."""
    rows = np.flatnonzero(measurement.judged)
    cut = rows[int(_SHARE * rows.size)]
    early = np.arange(measurement.judged.size) < cut
    return tuple(replace(measurement, judged=measurement.judged & part) for part in (early, ~early))


def table(models: Sequence[ModelRun], names: Sequence[str], view: View) -> str:
    """Samples as CSV: the marked ones, without a mark those of the stretch on view; all of them, not thinned.

    Columns are in SI units; forces pass the comparison band.

    Raises:
        InputError: for more than ``MOST_ROWS`` samples.
    """
    trace = models[0].traces[view.recording]
    inside = marked(models[0], view)
    time = trace.time - trace.time[0]
    if inside is None:
        ends = (-np.inf, np.inf) if view.start is None or view.stop is None else (view.start, view.stop)
        inside = (time >= ends[0]) & (time <= ends[1])
    rows = np.flatnonzero(inside)
    if rows.size > MOST_ROWS:
        raise InputError(f"{rows.size} samples are more than {MOST_ROWS}; zoom in or mark less")
    kinematics = trace.measurement.kinematics
    columns = {
        "time_s": time,
        "displacement_m": kinematics.displacement,
        "velocity_m_s": kinematics.velocity,
        "acceleration_m_s2": kinematics.acceleration,
        "force_measured_n": trace.measured,
    }
    for shown, name in zip(models, names, strict=True):
        trace = shown.traces[view.recording]
        columns[f"force_of_{name}_n"] = np.where(trace.judged, trace.modelled, np.nan)
    slow = {name: kinematics.block[row] for name, row in _SLOW.items()}
    columns |= {name: values for name, values in slow.items() if np.isfinite(values).any()}
    head = ",".join(f'"{name}"' if set(name) & set(',"\n') else name for name in columns)
    values = np.column_stack([column[rows] for column in columns.values()])
    lines = (",".join("" if np.isnan(value) else f"{value:.9g}" for value in row) for row in values)
    return "\n".join([head, *lines, ""])


def _rms(error: np.ndarray) -> str:
    return f"{number(float(np.sqrt(np.mean(error**2))))} N" if error.size else "not judged"
