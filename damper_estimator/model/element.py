"""One entry of a model: an effect with its values, and the path that it wraps, if any."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import count

from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.errors import InputError

Value = float | tuple[float, ...]


@dataclass(frozen=True)
class Element:
    """An effect in a model.

    Attributes:
        effect: its declaration.
        parameters: value of every parameter, a tuple for a vector, in declared order.
        settings: value of every setting, in declared order.
        path: the entries it wraps, for kinds ``path``, ``scaled`` and ``series``.
    """

    effect: Effect
    parameters: Mapping[str, Value] = field(default_factory=dict)
    settings: Mapping[str, Value] = field(default_factory=dict)
    path: tuple["Element", ...] = ()

    def with_values(self, values: Mapping[str, Value]) -> "Element":
        """The same entry with some parameters changed."""
        return replace(self, parameters={**self.parameters, **values})


def make_element(effect: Effect, values: Mapping[str, object] | None = None, path: tuple[Element, ...] = ()) -> Element:
    """An entry from parameter and setting values by name, with defaults for the others.

    Raises:
        InputError: names all faults: unknown names, wrong lengths, values out of bounds, an unexpected path.
    """
    given = dict(values or {})
    faults = [
        f"{name!r} is unknown (allowed: {', '.join(_names(effect)) or 'none'})"
        for name in given
        if name not in _names(effect)
    ]
    if effect.kind not in ("path", "scaled", "series") and path:
        faults.append("it accepts no path")
    if effect.kind in ("path", "scaled", "series") and not forces_of(path, effect):
        faults.append("its path is empty")
    if effect.kind == "scaled" and (others := [entry.effect.name for entry in path if entry.effect.kind != "modifier"]):
        faults.append(f"{', '.join(others)}: only modifiers can scale")
    if any(entry.effect.kind == "scaled" for entry in (path[1:] if effect.kind == "series" else path)):
        faults.append("scaled must be first in the path of a series effect")
    settings = {s.name: _checked_setting(s, given.get(s.name, s.default), faults) for s in effect.settings}
    parameters = {
        p.name: _checked_parameter(p, given.get(p.name), p.length(settings), faults) for p in effect.parameters
    }
    if faults:
        raise InputError(f"effect {effect.name}: {'; '.join(faults)}")
    return Element(effect, parameters, settings, path)


def forces_of(path: tuple[Element, ...], effect: Effect) -> tuple[Element, ...]:
    """The entries of a path without the modifiers that scale the wrapping series effect."""
    return path[1:] if effect.kind == "series" and path and path[0].effect.kind == "scaled" else path


def new_element(effect: Effect, before: tuple[Element, ...], values: Mapping[str, object] | None = None) -> Element:
    """An entry to be added to a model with the entries ``before``; ``DamperModel.with_effect`` chooses its position
    and, for a series effect, the wrapped entries.

    Raises:
        InputError: as ``make_element``.
    """
    if effect.kind != "series":
        return make_element(effect, values)
    return replace(make_element(effect, values, before), path=())


def _names(effect: Effect) -> list[str]:
    return [declared.name for declared in (*effect.parameters, *effect.settings)]


def _numbers(value: object) -> tuple[float, ...] | None:
    """The value as a tuple of floats; None for anything else."""
    items = value if isinstance(value, list | tuple) else (value,)
    if not all(isinstance(item, int | float) and not isinstance(item, bool) for item in items):
        return None
    return tuple(float(item) for item in items)


def _checked_setting(setting, value: object, faults: list[str]) -> Value:
    numbers = _numbers(value)
    listed = isinstance(setting.default, tuple)
    if numbers is None or (not listed and isinstance(value, list | tuple)):
        faults.append(f"{setting.name} = {value!r} is not a {'list of numbers' if listed else 'number'}")
        return setting.default
    if any(not setting.lower <= number <= setting.upper for number in numbers):
        faults.append(f"{setting.name} = {value!r} is outside {setting.lower:g} to {setting.upper:g} {setting.unit}")
    if setting.increasing and (len(numbers) < 2 or any(b <= a for a, b in zip(numbers, numbers[1:], strict=False))):
        faults.append(f"{setting.name} must have two or more values in rising order")
        return setting.default
    return numbers if listed else numbers[0]


def _checked_parameter(parameter: Parameter, value: object, length: int | None, faults: list[str]) -> Value:
    default = parameter.default if length is None else (parameter.default,) * length
    numbers = _numbers(default if value is None else value)
    if numbers is None or (length is None and isinstance(value, list | tuple)):
        faults.append(f"{parameter.name} = {value!r} is not a number")
        return default
    if length is not None and len(numbers) != length:
        sized_by = parameter.size if isinstance(parameter.size, str) else " x ".join(parameter.size or ())
        faults.append(f"{parameter.name} has {len(numbers)} values, {sized_by} has {length}")
    for number in numbers:
        if not parameter.lower <= number <= parameter.upper:
            faults.append(
                f"{parameter.name} = {number:g} is outside {parameter.lower:g} to {parameter.upper:g} {parameter.unit}"
            )
    return numbers if length is not None else numbers[0]


def walk(elements: tuple[Element, ...]) -> Iterator[Element]:
    """All entries in order, each before what it wraps."""
    for element in elements:
        yield element
        yield from walk(element.path)


def labels(elements: tuple[Element, ...]) -> list[tuple[str, Element]]:
    """Label of every entry in order of ``walk``: the effect's name, ``name#2`` for a second instance."""
    seen: dict[str, int] = {}
    named = []
    for element in walk(elements):
        times = seen[element.effect.name] = seen.get(element.effect.name, 0) + 1
        named.append((element.effect.name if times == 1 else f"{element.effect.name}#{times}", element))
    return named


def with_values_of(elements: tuple[Element, ...], values: Mapping[int, Mapping[str, Value]]) -> tuple[Element, ...]:
    """The entries with other parameter values, by position in order of ``walk``."""
    return _with_values(elements, values, count())


def _with_values(
    elements: tuple[Element, ...], values: Mapping[int, Mapping[str, Value]], positions: Iterator[int]
) -> tuple[Element, ...]:
    changed = []
    for element in elements:
        parameters = {**element.parameters, **values.get(next(positions), {})}
        inner = _with_values(element.path, values, positions)
        changed.append(Element(element.effect, parameters, element.settings, inner))
    return tuple(changed)
