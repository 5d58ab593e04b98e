"""Partial coherence: the share of the force that each of displacement, velocity and acceleration adds to the others.

    g_iy.rest^2 = |P_iy|^2 / (P_ii P_yy),      P = inverse of the cross-spectral matrix of all inputs and the force

Velocity and acceleration are the displacement's derivatives: any of them, unchanged, explains all of the others, and
their partial coherences do not exist. So each is replaced by a curve, the mean force over it; the curves are found in
turns until they add up (an additive model); curves that bend differently are no longer copies of each other. A curve
that another still explains to 99.9 % at a frequency has NaN there. Source: Bendat and Piersol, Random Data, chapter 7;
black-box paper, reference 9 (partial coherence), by curves instead of raw signals for the reason given.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from scipy import signal

from damper_estimator.signals import Measurement

_SEGMENT = 2.0  # s
_LEAST_SEGMENTS = 8
_INDEPENDENT = 1e-3  # share of an input that the others leave, at least
_BINS, _TURNS = 60, 6
_LEAST_CURVE = 0.02  # rms of a curve over that of the force below which it says nothing; its partial coherence is 0


@dataclass(frozen=True)
class PartialCoherence:
    """By frequency; empty where the recordings are too short.

    Attributes:
        frequency: (k,) Hz, up to the comparison band.
        partial: (k,) 0 to 1 by input, given the others; NaN where it is undetermined.
        ordinary: (k,) 0 to 1 by input alone.
        multiple: (k,) 0 to 1, all inputs together.
        curve_rms_n: N, rms of the curve over each input, where curves were used.
    """

    frequency: np.ndarray
    partial: Mapping[str, np.ndarray]
    ordinary: Mapping[str, np.ndarray]
    multiple: np.ndarray
    curve_rms_n: Mapping[str, float] = field(default_factory=dict)

    def record(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def partial_coherence(measurements: Sequence[Measurement]) -> PartialCoherence:
    """Of the measured force with the curves over velocity, displacement and acceleration, all recordings pooled."""
    curves, sizes, large = _large_curves(measurements)
    rate = float(np.median([m.kinematics.rate for m in measurements]))
    parts = []
    for m in measurements:
        columns = [m.force, *(np.interp(getattr(m.kinematics, n), *curves[n]) for n in large)]
        parts += _even_parts(m, columns, rate)
    found = coherences(large, parts, rate, max(m.band for m in measurements))
    nothing = {n: np.zeros(found.frequency.size) for n in curves}
    partial, ordinary = nothing | dict(found.partial), nothing | dict(found.ordinary)
    return replace(found, partial=partial, ordinary=ordinary, curve_rms_n=sizes)


def _large_curves(
    measurements: Sequence[Measurement],
) -> tuple[dict[str, tuple[np.ndarray, np.ndarray]], dict[str, float], list[str]]:
    """The curves over the motion, their sizes in N rms, and the names of those large enough to use, at least one."""
    names, judged = ("velocity", "displacement", "acceleration"), [m.judged for m in measurements]
    raw = {
        n: np.concatenate([getattr(m.kinematics, n)[j] for m, j in zip(measurements, judged, strict=True)])
        for n in names
    }
    force = np.concatenate([m.force[j] for m, j in zip(measurements, judged, strict=True)])
    curves = additive_curves(raw, force)
    sizes = {n: float(np.std(np.interp(raw[n], *curves[n]))) for n in names}
    return curves, sizes, [n for n in names if sizes[n] >= _LEAST_CURVE * force.std()] or list(names[:1])


def additive_curves(inputs: Mapping[str, np.ndarray], force: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The mean force over each input, given the others: knots (b,) and values (b,) by input.

    F = mean + sum_i c_i(u_i), each c_i in turn the binned mean of the others' residual.
    """
    places, centres = {}, {}
    for name, values in inputs.items():
        edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, _BINS + 1)))
        place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, max(edges.size - 2, 0))
        places[name] = place.astype(np.int16)
        count = np.bincount(place, minlength=max(edges.size - 1, 1))
        centres[name] = np.bincount(place, values, count.size) / np.maximum(count, 1)
    curves = {name: np.zeros(centre.size) for name, centre in centres.items()}
    for _ in range(_TURNS):
        for name, place in places.items():
            others = sum((curves[other][places[other]] for other in inputs if other != name), np.zeros(force.size))
            count = np.bincount(place, minlength=curves[name].size)
            mean = np.bincount(place, force - force.mean() - others, curves[name].size) / np.maximum(count, 1)
            curves[name] = mean - float(np.average(mean, weights=count))
    return {name: (centres[name], curves[name]) for name in inputs}


def _even_parts(measurement: Measurement, columns: Sequence[np.ndarray], rate: float) -> list[np.ndarray]:
    """The judged runs of columns (n,) on an even grid, (c, r) each."""
    time, parts = measurement.kinematics.time, []
    for part in measurement.kinematics.stretches():
        inside = np.flatnonzero(measurement.judged[part]) + part.start
        for run in np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1):
            if run.size > 8:
                even = np.arange(time[run[0]], time[run[-1]], 1.0 / rate)
                parts.append(np.stack([np.interp(even, time[run], column[run]) for column in columns]))
    return parts


def coherences(names: Sequence[str], parts: Sequence[np.ndarray], rate: float, band: float) -> PartialCoherence:
    """Partial, ordinary and multiple coherences of an output with several inputs.

    Args:
        names: of the inputs, in order.
        parts: (1 + inputs, n) each, the output first, evenly sampled.
        rate: Hz.
        band: Hz, the highest frequency returned; 0 for all.
    """
    size = round(_SEGMENT * rate)
    long = [part for part in parts if part.shape[1] >= size >= 8]
    if sum(2 * part.shape[1] // size - 1 for part in long) < _LEAST_SEGMENTS:
        empty = {name: np.zeros(0) for name in names}
        return PartialCoherence(np.zeros(0), empty, empty, np.zeros(0))
    frequency = np.fft.rfftfreq(size, 1.0 / rate)
    inside = (frequency > 0.0) & (frequency <= (band or np.inf))
    spectra = sum(_matrix(part, rate, size) for part in long)[inside]
    # Scaled to unit diagonal: coherences do not depend on units, the inverse's accuracy does.
    scale = np.sqrt(np.maximum(np.einsum("kii->ki", spectra).real, 1e-300))
    spectra = spectra / (scale[:, :, None] * scale[:, None, :])
    spectra = spectra + 1e-9 * np.eye(spectra.shape[1])
    whole, inputs = np.linalg.inv(spectra), np.linalg.inv(spectra[:, 1:, 1:])
    diagonal = np.einsum("kii->ki", whole).real
    partial, ordinary = {}, {}
    for i, name in enumerate(names, start=1):
        left = 1.0 / inputs[:, i - 1, i - 1].real
        value = np.abs(whole[:, i, 0]) ** 2 / (diagonal[:, i] * diagonal[:, 0])
        partial[name] = np.where(left >= _INDEPENDENT, np.clip(value, 0.0, 1.0), np.nan)
        ordinary[name] = np.clip(np.abs(spectra[:, i, 0]) ** 2, 0.0, 1.0)
    return PartialCoherence(frequency[inside], partial, ordinary, np.clip(1.0 - 1.0 / diagonal[:, 0], 0.0, 1.0))


def _matrix(part: np.ndarray, rate: float, size: int) -> np.ndarray:
    """(frequencies, c, c) cross spectra of the columns, weighted by the number of segments."""
    weight = 2 * part.shape[1] // size - 1
    rows = [[signal.csd(a, b, fs=rate, nperseg=size)[1] for b in part] for a in part]
    return weight * np.moveaxis(np.array(rows), 2, 0)
