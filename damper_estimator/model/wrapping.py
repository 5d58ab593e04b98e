"""What a series effect is wrapped around, what acts beside it, and what remains when it is removed."""

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
        (beside if spring.effect.of_oil and element.effect.beside_oil else carried).append(element)
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
