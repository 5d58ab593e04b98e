"""A model of one damper: an immutable, ordered list of effects with methods that return changed copies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from damper_estimator.effects.contract import Parameter, flat
from damper_estimator.errors import InputError
from damper_estimator.model.element import Element, labels, walk, with_values_of
from damper_estimator.model.program import Program, compile_program, refilled
from damper_estimator.model.stream import Stream
from damper_estimator.model.wrapping import (
    carried_count,
    exchanged,
    in_series,
    on_the_flow,
    removed,
    springs_of,
    with_source,
    wrapped,
)

if TYPE_CHECKING:
    from damper_estimator.workflows import WrittenC, WrittenFmu


@dataclass(frozen=True)
class Slot:
    """One number of a model that identification can change.

    Attributes:
        address: such as ``coulomb.force``, ``bouc_wen#2.alpha``, ``viscous_curve.force[3]``.
        value: current value.
        parameter: its declaration (unit, bounds, meaning).
        entry: position of its effect in order of ``walk``.
        index: position in a vector parameter, None for a scalar.
        fixed: whether identification leaves it unchanged.
    """

    address: str
    value: float
    parameter: Parameter
    entry: int
    index: int | None
    fixed: bool

    @property
    def is_at_bound(self) -> bool:
        """Whether identification left it at a bound of its declaration."""
        low, high = self.parameter.lower, self.parameter.upper
        return not self.fixed and min(self.value - low, high - self.value) <= 1e-6 * (high - low)


@dataclass(frozen=True)
class DamperModel:
    """One damper's model.

    Attributes:
        name, source: from the model file.
        effects: entries in order; order is physics (sources, then what acts on their sum).
        fixed: addresses that identification leaves unchanged unless requested otherwise.
        notes: decisions about the published model, with reasons.
        fit: results of the last identification: bags, date, cutoff, residual deviation, region, standard errors.
    """

    name: str
    source: str
    effects: tuple[Element, ...]
    fixed: tuple[str, ...] = ()
    notes: str = ""
    fit: Mapping[str, object] = field(default_factory=dict)

    @cached_property
    def program(self) -> Program:
        """The compiled model for the chain."""
        return compile_program(self.effects)

    @cached_property
    def slots(self) -> tuple[Slot, ...]:
        """Every number that identification can change, in order."""
        slots = []
        for entry, (label, element) in enumerate(labels(self.effects)):
            for parameter in element.effect.parameters:
                value = element.parameters[parameter.name]
                items = [(None, value)] if parameter.size is None else list(enumerate(value))
                for index, number in items:
                    address = f"{label}.{parameter.name}" + ("" if index is None else f"[{index}]")
                    fixed = address in self.fixed or f"{label}.{parameter.name}" in self.fixed
                    slots.append(Slot(address, float(number), parameter, entry, index, fixed))
        return tuple(slots)

    @property
    def knots(self) -> dict[str, str]:
        """Position of each entry of a vector parameter on its curve, such as ``at -0.15 m/s``, by address."""
        places, elements = {}, labels(self.effects)
        for slot in self.slots:
            _, element = elements[slot.entry]
            if isinstance(slot.parameter.size, str):
                unit = {setting.name: setting.unit for setting in element.effect.settings}[slot.parameter.size]
                places[slot.address] = f"at {element.settings[slot.parameter.size][slot.index]:.4g} {unit}"
        return places

    @property
    def standard_errors(self) -> dict[str, float]:
        """Of identified parameters by address, as the record of the fit states them; empty without one."""
        errors = self.fit.get("standard_errors")
        stated = errors.items() if isinstance(errors, Mapping) else ()
        return {str(name): float(error) for name, error in stated if isinstance(error, (int, float))}

    def __repr__(self) -> str:
        """Name and labels of the effects; ``model_yaml`` returns the whole model."""
        return f"DamperModel({self.name}: {', '.join(label for label, _ in labels(self.effects))})"

    def __getstate__(self) -> dict[str, object]:
        """The declaration, for another process; the compiled program is built again there."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    def stream(self) -> Stream:
        """A new stream with the initial state."""
        return Stream(self.program)

    def force(self, block: np.ndarray) -> np.ndarray:
        """Forces (n,) in N over a whole block (8, n), from the initial state."""
        return self.stream().force(block)

    def force_at(self, vector: np.ndarray, block: np.ndarray) -> np.ndarray:
        """``with_vector(vector).force(block)``, without the model: what a search asks for many thousand times."""
        if self._prepares:
            return self.with_vector(vector).force(block)
        changed = replace(self.program, parameters=np.array(vector, float))
        return Stream(changed).force(block)

    @cached_property
    def _prepares(self) -> bool:
        """Whether settings of kernels follow from parameters."""
        return any(element.effect.prepare is not flat for element in walk(self.effects))

    def contributions(self, block: np.ndarray) -> dict[str, np.ndarray]:
        """Contribution of each entry to the force, (n,) in N by label; the sum is ``force``.

        That of a compliance is what it changes of the force of all that it wraps.
        """
        wraps = next((label for label, e in labels(self.effects) if e.effect.kind == "series"), None)
        if wraps is not None:
            less = self.without(wraps)
            known = {id(element.parameters): label for label, element in labels(self.effects)}
            named = {label: known[id(element.parameters)] for label, element in labels(less.effects)}
            inside = {named[label]: part for label, part in less.contributions(block).items()}
            return {wraps: self.force(block) - sum(inside.values()), **inside}
        _, parts = self.stream().contributions(block)
        return {
            label: part
            for (label, element), part in zip(labels(self.effects), parts, strict=True)
            if element.effect.kernel is not None
        }

    def with_values(self, values: Mapping[str, float]) -> "DamperModel":
        """The model with some numbers changed, by address, without the results of its last fit.

        Raises:
            InputError: names every unknown address.
        """
        unknown = [address for address in values if address not in {slot.address for slot in self.slots}]
        if unknown:
            raise InputError(
                f"model {self.name}: has no parameter {', '.join(unknown)}; it has "
                f"{', '.join(s.address for s in self.slots)}"
            )
        vector = np.array([values.get(slot.address, slot.value) for slot in self.slots])
        return self.with_vector(vector)

    def with_vector(self, vector: np.ndarray) -> "DamperModel":
        """The model with all numbers changed, in order of ``slots``; reuses the compiled program."""
        by_entry: dict[int, dict[str, float | tuple[float, ...]]] = {}
        for slot, number in zip(self.slots, vector, strict=True):
            values = by_entry.setdefault(slot.entry, {})
            if slot.index is None:
                values[slot.parameter.name] = float(number)
            else:
                values[slot.parameter.name] = (*values.get(slot.parameter.name, ()), float(number))
        changed = replace(self, effects=with_values_of(self.effects, by_entry), fit={})
        # The structure is the same, so the program is refilled; the class is frozen only for its users.
        changed.__dict__["program"] = refilled(self.program, changed.effects)
        return changed

    def with_effect(self, element: Element) -> "DamperModel":
        """The model with an additional entry at the position that its kind requires.

        A source goes before the first modifier of the top level, a modifier or channel effect to the end, an input
        effect to the front; a series effect wraps all that makes the damper's force, the oil what acts through it.
        """
        head = [e for e in self.effects if e.effect.kind in ("source", "path", "series", "input")]
        count = next((i for i, e in enumerate(self.effects) if e not in head), len(self.effects))
        kind = element.effect.kind
        if kind == "input":
            effects = (element, *self.effects)
        elif kind in ("source", "path"):
            effects = (*self.effects[:count], element, *self.effects[count:])
        elif kind == "series":
            count = carried_count(self.effects)
            effects = (*wrapped(element, self.effects[:count]), *self.effects[count:])
        elif kind == "modifier":
            channels = [e for e in self.effects if e.effect.kind == "channel"]
            effects = (*(e for e in self.effects if e not in channels), element, *channels)
        else:
            effects = (*self.effects, element)
        return self._with(effects)

    @property
    def springs(self) -> tuple[Element, ...]:
        """The series springs in a row that carry the sources: the mount or joint, the oil behind it."""
        return springs_of(self.effects)

    def with_missing(self, element: Element) -> "DamperModel":
        """The model with an entry that was missing: it acts in parallel to all that is there, or on all of it.

        As ``with_effect``, but a source goes behind the modifiers, or into the path of a series spring, as does what
        changes the oil's flow, and a series effect to its place in a row (``in_series``). Springs in front of a new one
        or behind it keep their stiffness: how they share a deflection does not show in the force.
        """
        kind = element.effect.kind
        if kind == "series":
            changed = self._with(in_series(element, self.effects))
            return changed._with_fixed(self.springs) if element.effect.is_series_spring else changed
        if kind == "input" and element.effect.of_oil:
            return self._with(on_the_flow(element, self.effects))
        carried = with_source(element, self.effects) if kind in ("source", "path") else None
        if carried is not None:
            return self._with(carried)
        if kind in ("source", "path"):
            channels = [e for e in self.effects if e.effect.kind == "channel"]
            return self._with((*(e for e in self.effects if e not in channels), element, *channels))
        return self.with_effect(element)

    def _with_fixed(self, elements: tuple[Element, ...]) -> "DamperModel":
        """The model with the parameters fixed of those of these entries that it has."""
        kept, entries = {id(one.parameters) for one in elements}, list(walk(self.effects))
        held = [slot.address for slot in self.slots if id(entries[slot.entry].parameters) in kept]
        return replace(self, fixed=tuple(dict.fromkeys((*self.fixed, *held))))

    def without(self, label: str) -> "DamperModel":
        """The model without one entry; entries that a series effect wrapped remain.

        Raises:
            InputError: for an unknown entry.
        """
        entries = dict(labels(self.effects))
        if label not in entries:
            raise InputError(f"model {self.name}: has no effect {label}; it has {', '.join(entries)}")
        return self._with(removed(self.effects, entries[label]))

    def with_instead(self, gone: Sequence[str], element: Element) -> "DamperModel":
        """The model with an entry in the place of some others, by label: where the first of them is."""
        entries = dict(labels(self.effects))
        return self._with(exchanged(self.effects, [entries[label] for label in gone], element))

    def _with(self, effects: tuple[Element, ...]) -> "DamperModel":
        """The model with other entries and no record of a fit; parameters that were fixed and remain stay fixed."""
        now = {id(element.parameters): label for label, element in labels(effects)}
        fixed = []
        for label, element in labels(self.effects):
            if id(element.parameters) in now:
                prefix = f"{label}."
                fixed += [f"{now[id(element.parameters)]}.{one.removeprefix(prefix)}" for one in self.fixed
                          if one.startswith(prefix)]  # fmt: skip
        return replace(self, effects=effects, fixed=tuple(fixed), fit={})

    # The exporters import this module, so these two methods import them when called.
    def to_c(self, folder: str | PathLike[str], **options: Any) -> "WrittenC":
        """Writes the model as C99, ``NAME.h`` and ``NAME.c``, into a folder; ``options`` as in `damper_estimator.to_c`.

        Raises:
            InputError: as `damper_estimator.to_c`.
        """
        from damper_estimator.workflows import to_c

        return to_c(self, folder, **options)

    def to_fmu(self, path: str | PathLike[str], **options: Any) -> "WrittenFmu":
        """Writes the model as an FMU for co-simulation; ``options`` as in `damper_estimator.to_fmu`.

        Raises:
            InputError: as `damper_estimator.to_fmu`.
        """
        from damper_estimator.workflows import to_fmu

        return to_fmu(self, path, **options)

    @property
    def channel_effects(self) -> list[str]:
        """Labels of effects of the measurement chain; a deployed model has none."""
        return [label for label, element in labels(self.effects) if element.effect.kind == "channel"]

    def uses(self) -> set[str]:
        """Names of the model's effects."""
        return {element.effect.name for element in walk(self.effects)}
