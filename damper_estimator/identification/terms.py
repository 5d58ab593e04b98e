"""Takes a model apart into parts whose forces add up, and finds the parameters in which a part is linear.

A linear parameter can be solved for instead of searched, but only where every later entry of its list, and of the
lists around it, is linear in the force. What stands before an entry that is not, or behind a compliance, stays
together as one part. What a linear entry adds by itself, such as a scale that leaves the force at rest as it is, is in
one part only.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from damper_estimator.effects.contract import Effect
from damper_estimator.model import DamperModel, Element


@dataclass(frozen=True)
class Term:
    """One part of a model; the model's force is the sum of its terms' forces.

    Attributes:
        model: the entries that make this part, and those that act on it, as a separate model.
        slots: positions in the whole model's ``slots`` of this part's slots, in the same order.
        linear: those of ``slots`` to which the part's force is proportional, taken together; empty where there are
            none.
    """

    model: DamperModel
    slots: tuple[int, ...]
    linear: tuple[int, ...]

    @property
    def searched(self) -> tuple[int, ...]:
        """Positions of the slots on which the part depends nonlinearly."""
        return tuple(slot for slot in self.slots if slot not in self.linear)


@dataclass(frozen=True)
class _Node:
    """An entry with its position in order of ``walk``."""

    position: int
    element: Element
    path: tuple["_Node", ...]

    @property
    def all_positions(self) -> frozenset[int]:
        return frozenset({self.position}).union(*(inner.all_positions for inner in self.path))


@dataclass(frozen=True)
class _Part:
    kept: frozenset[int]
    source: _Node | None = None  # the entry that makes the force, where all entries acting on it are linear
    acting: frozenset[int] = frozenset()  # entries that add nothing to it, because they do so in another part


def terms(model: DamperModel) -> tuple[Term, ...]:
    """The parts of a model whose forces add up to its force."""
    nodes, _ = _numbered(model.effects, 0)
    return tuple(_term(model, part) for part in _split(nodes))


def _numbered(elements: Sequence[Element], first: int) -> tuple[tuple[_Node, ...], int]:
    nodes = []
    for element in elements:
        position = first
        path, first = _numbered(element.path, first + 1)
        nodes.append(_Node(position, element, path))
    return tuple(nodes), first


def adds(effect: Effect) -> bool:
    """Whether an effect adds a force; otherwise it acts on the force or on the motion.

    A channel effect with linear parameters (an offset, a spring rate) adds, one without (a gain, a skew) rewrites.
    """
    return effect.kind in ("source", "path", "series") or (
        effect.kind == "channel" and any(p.linear for p in effect.parameters)
    )


def _split(nodes: tuple[_Node, ...]) -> list[_Part]:
    adding = [adds(node.element.effect) for node in nodes]
    bent = [i for i, node in enumerate(nodes) if not node.element.effect.linear and not adding[i]]
    if any(nodes[i].element.effect.kind == "input" for i in bent):
        return [_Part(frozenset().union(*(node.all_positions for node in nodes)))]
    last_bent = max(bent, default=-1)
    rewriting = [node for i, node in enumerate(nodes) if not adding[i]]
    parts = []
    if bent:
        together = [node for i, node in enumerate(nodes) if i <= last_bent or not adding[i]]
        parts.append(_Part(frozenset().union(*(node.all_positions for node in together))))
    elif any(_adds_by_itself(node.element) for node in rewriting):
        parts.append(_Part(frozenset(node.position for node in rewriting)))
    for i, node in enumerate(nodes):
        if i > last_bent and adding[i]:
            acting = frozenset(
                other.position
                for j, other in enumerate(nodes)
                if not adding[j] and (j > i or other.element.effect.kind == "input")
            )
            parts += [_Part(part.kept | acting, part.source, part.acting | acting) for part in _inside(node)]
    return parts


def _adds_by_itself(element: Element) -> bool:
    return any(setting.adds and element.settings[setting.name] for setting in element.effect.settings)


def _inside(node: _Node) -> list[_Part]:
    kind = node.element.effect.kind
    if kind == "path":
        return [replace(part, kept=part.kept | {node.position}) for part in _split(node.path)]
    return [_Part(node.all_positions, None if kind == "series" else node)]


def _term(model: DamperModel, part: _Part) -> Term:
    slots = tuple(i for i, slot in enumerate(model.slots) if slot.entry in part.kept)
    linear = ()
    if part.source is not None:
        linear = tuple(
            i for i in slots if model.slots[i].entry == part.source.position and model.slots[i].parameter.linear
        )
    alone = replace(model, effects=_pruned(model.effects, part, [0]), fixed=(), fit={})
    return Term(alone, slots, linear)


def _pruned(elements: tuple[Element, ...], part: _Part, counter: list[int]) -> tuple[Element, ...]:
    left = []
    for element in elements:
        position = counter[0]
        counter[0] += 1
        path = _pruned(element.path, part, counter)
        if position in part.kept:
            nothing = {s.name: 0.0 for s in element.effect.settings if s.adds and position in part.acting}
            left.append(replace(element, path=path, settings={**element.settings, **nothing}))
    return tuple(left)
