"""Lays the knots of look-up curves over the range of the recording, where the model file kept the effect's default.

An effect with a rising list setting that gives a vector parameter its length is a curve (with several such, a
surface), and the setting's unit determines its axis (m/s: velocity, m: displacement, m/s^2: acceleration, A: command,
deg C: temperature). Its default knots are stretched, each side of zero by itself, so that the outer ones stand at
the 0.5 and 99.5 percentiles; 0 stays where it is; a knot is left out where a neighbouring interval would hold too
few samples to determine it. An axis of magnitudes, such as a speed, is stretched up to the larger of the two sides.
Knots that a model file gives are never moved.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.effects.contract import Parameter, Setting
from damper_estimator.identification.samples import Channels, Samples, channels_of
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import Value, labels
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, TEMPERATURE, A, V, X

AXES = {"m/s": V, "m": X, "m/s^2": A, "A": COMMAND, "deg C": TEMPERATURE}
OUTER = (0.5, 99.5)  # percentiles
FEWEST = 30  # samples between two knots, and a thousandth of all


def with_placed_knots(model: DamperModel, measurements: Sequence[Measurement]) -> DamperModel:
    """The model with its default knots laid over the judged samples of the measurements; values are interpolated."""
    return with_knots_over(model, channels_of(measurements))


def with_knots_over(model: DamperModel, channels: Channels) -> DamperModel:
    """The model with its default knots laid over the values of each channel."""
    return replace(model, effects=tuple(_placed(element, channels) for element in model.effects))


def moved_knots(before: DamperModel, after: DamperModel) -> list[str]:
    """Labels of the entries whose settings differ."""
    pairs = zip(labels(before.effects), labels(after.effects), strict=True)
    return [label for (label, old), (_, new) in pairs if old.settings != new.settings]


def with_knots_of(model: DamperModel, other: DamperModel) -> DamperModel:
    """The model with its curves read off at the knots of another one that has the same entries."""
    pairs = zip(model.effects, other.effects, strict=True)
    return replace(model, effects=tuple(_read_off(element, laid_out) for element, laid_out in pairs))


def _read_off(element: Element, other: Element) -> Element:
    path = tuple(_read_off(inner, laid_out) for inner, laid_out in zip(element.path, other.path, strict=True))
    differing = {name for name, value in other.settings.items() if value != element.settings[name]}
    curves = {
        p.name: _interpolated(p, element, other.settings)
        for p in element.effect.parameters
        if differing.intersection(p.axes)
    }
    parameters = {**element.parameters, **curves}
    return replace(element, path=path, settings=other.settings, parameters=parameters)


def _placed(element: Element, channels: Channels) -> Element:
    element = replace(element, path=tuple(_placed(inner, channels) for inner in element.path))
    axes = {}
    for setting in element.effect.settings:
        row = AXES.get(setting.unit)
        shapes_table = any(setting.name in p.axes for p in element.effect.parameters)
        if (
            shapes_table
            and setting.increasing
            and row is not None
            and element.settings[setting.name] == setting.default
        ):
            axes[setting.name] = tuple(_knots(setting, channels(row)))
    moved = [p for p in element.effect.parameters if any(name in axes for name in p.axes)]
    given = [p for p in moved if len(p.axes) > 1 and len(set(element.parameters[p.name])) > 1]
    if not axes or given:  # a surface with values is the user's
        return element
    settings = {**element.settings, **axes}
    curves = {p.name: _interpolated(p, element, settings) for p in moved}
    return replace(element, settings=settings, parameters={**element.parameters, **curves})


def _interpolated(parameter: Parameter, element: Element, settings: Mapping[str, Value]) -> tuple[float, ...]:
    values = element.parameters[parameter.name]
    if not isinstance(parameter.size, str):
        return values[:1] * (parameter.length(settings) or 0)
    return tuple(np.interp(settings[parameter.size], element.settings[parameter.size], values).tolist())


def _knots(setting: Setting, values: Samples) -> list[float]:
    """Stretched knots that have enough samples around them; the default ones where the values do not spread."""
    default = np.asarray(setting.default)
    if values.size == 0 or values.low == values.high:
        return default.tolist()
    low, high = values.percentiles(OUTER)
    below = values.below
    if setting.lower >= 0.0 and values.low < 0.0:  # an axis of magnitudes, such as the speed
        stretched = default * max(-low, high) / default[-1]
        below = _magnitudes_below(values)
    elif default[0] < 0.0 < default[-1] and low < 0.0 < high:
        stretched = np.where(default < 0.0, default * low / default[0], default * high / default[-1])
    else:
        stretched = low + (default - default[0]) * (high - low) / (default[-1] - default[0])
    kept = _populated(stretched.tolist(), below, max(FEWEST, values.size // 1000))
    return kept if len(kept) > 1 else default.tolist()


def _magnitudes_below(values: Samples) -> Callable[[Sequence[float]], np.ndarray]:
    return lambda edges: values.below(edges) - values.below([-edge for edge in edges])


def _populated(knots: list[float], count: Callable[[Sequence[float]], np.ndarray], fewest: int) -> list[float]:
    """Knots without those that close an interval of fewer than ``fewest`` samples; 0 and the ends go last.

    ``count``: how many samples are below each edge.
    """
    below = dict(zip(knots, count(knots).tolist(), strict=True))
    while len(knots) > 2:
        counts = np.diff([below[knot] for knot in knots])
        thin = int(np.argmin(counts))
        if counts[thin] >= fewest:
            break
        pair = [i for i in (thin, thin + 1) if 0 < i < len(knots) - 1]
        movable = [i for i in pair if knots[i] != 0.0] or pair
        # Of the two, the one whose other interval is the poorer.
        gone = min(movable, key=lambda i: counts[i - 1] + counts[i])
        knots = knots[:gone] + knots[gone + 1 :]
    return [float(f"{knot:.6g}") for knot in knots]
