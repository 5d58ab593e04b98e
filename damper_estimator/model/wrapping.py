"""What a series effect is wrapped around, what acts beside it, and what remains when it is removed."""

from collections.abc import Sequence
from dataclasses import replace

from damper_estimator.model.element import Element, forces_of


def carried_count(elements: tuple[Element, ...]) -> int:
    """How many entries, from the first, a series effect is wrapped around: all before the measurement chain, and before
    what only delays the whole.
    """
    count = next((i for i, element in enumerate(elements) if element.effect.kind == "channel"), len(elements))
    while count and elements[count - 1].effect.delays:
        count -= 1
    return count


def springs_of(entries: tuple[Element, ...]) -> tuple[Element, ...]:
    """The series springs in a row that carry the sources of a level: the mount or joint, the oil behind it."""
    spring = next((element for element in entries if element.effect.is_series_spring), None)
    return () if spring is None else (spring, *springs_of(spring.path))


def carries(spring: Element, beside_oil: bool) -> bool:
    """Whether a series spring carries a source: the oil none that acts beside it."""
    return not (spring.effect.of_oil and beside_oil)


def in_series(element: Element, entries: tuple[Element, ...]) -> tuple[Element, ...]:
    """Entries with a series effect in its place of a row: mount, oil, passages beside the valves.

    A spring takes the place of the present one of the mount, or of the oil: two alike in a row are one.
    """
    present = next((one for one in entries if one.effect.is_series_spring), None)
    if present is None or _rank(element) < _rank(present):
        count = carried_count(entries)
        return (*wrapped(element, entries[:count]), *entries[count:])
    if _rank(element) == _rank(present):
        instead = wrapped(element, present.path)
    else:
        instead = (replace(present, path=in_series(element, present.path)),)
    place = entries.index(present)
    return (*entries[:place], *instead, *entries[place + 1 :])


def _rank(element: Element) -> int:
    """Of a series effect in a row, from the outside."""
    return (1 if element.effect.of_oil else 0) if element.effect.is_series_spring else 2


def with_source(source: Element, entries: tuple[Element, ...]) -> tuple[Element, ...] | None:
    """Entries with a source or path behind the series springs that carry it; None where none does."""
    present = next((element for element in entries if element.effect.is_series_spring), None)
    if present is None or not carries(present, source.effect.beside_oil):
        return None
    longer = replace(present, path=with_source(source, present.path) or (*present.path, source))
    return tuple(longer if element is present else element for element in entries)


def on_the_flow(element: Element, entries: tuple[Element, ...]) -> tuple[Element, ...]:
    """Entries with an input effect that changes the oil's flow: in front of what the oil flows through, behind the
    series springs.
    """
    present = next((one for one in entries if one.effect.is_series_spring), None)
    if present is None:
        return (element, *entries)
    inside = replace(present, path=on_the_flow(element, present.path))
    return tuple(inside if one is present else one for one in entries)


def wrapped(spring: Element, entries: tuple[Element, ...]) -> tuple[Element, ...]:
    """A series effect around entries, followed by those that act beside it, as forces on the rod do beside the oil.

    What a modifier acts on stays in front of it, and the oil carries all if nothing else is left for it. A path that
    the effect already has takes the place of the same entries.
    """
    if spring.path:
        return (spring, *_others(entries, spring.path))
    free = max((i for i, e in enumerate(entries, 1) if e.effect.kind == "modifier" and not e.effect.delays), default=0)
    carried, beside = list(entries[:free]), []
    for element in entries[free:]:
        (carried if carries(spring, element.effect.beside_oil) else beside).append(element)
    if not forces_of(tuple(carried), spring.effect):
        return (replace(spring, path=entries),)
    return (replace(spring, path=tuple(carried)), *beside)


def _others(entries: tuple[Element, ...], taken: tuple[Element, ...]) -> list[Element]:
    """The entries that are not among the taken ones, whose values may have changed."""
    names, others = [e.effect.name for e in taken], []
    for element in entries:
        if element.effect.name in names:
            names.remove(element.effect.name)
        else:
            others.append(element)
    return others


def removed(elements: tuple[Element, ...], gone: Element) -> tuple[Element, ...]:
    """The entries without one, in paths too; what a series effect wrapped remains."""
    kept: list[Element] = []
    for element in elements:
        if element is gone:
            kept += forces_of(element.path, element.effect) if element.effect.kind == "series" else ()
        else:
            kept.append(replace(element, path=removed(element.path, gone)) if element.path else element)
    return tuple(kept)


def exchanged(elements: tuple[Element, ...], gone: Sequence[Element], instead: Element) -> tuple[Element, ...]:
    """The entries with another one in the place of the first of some, in paths too."""
    kept: list[Element] = []
    for element in elements:
        if element is gone[0]:
            kept.append(instead)
        elif not any(element is one for one in gone):
            kept.append(replace(element, path=exchanged(element.path, gone, instead)) if element.path else element)
    return tuple(kept)
