"""Selects the parameters of a model that a fit may change: the model file's choice, then ``--fix``, then ``--free``."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase

from damper_estimator.errors import InputError, did_you_mean
from damper_estimator.model import DamperModel, Slot


def free_slots(model: DamperModel, free: Iterable[str] = (), fix: Iterable[str] = ()) -> tuple[int, ...]:
    """Positions in ``model.slots`` of the parameters that are identified.

    The later choice wins: what the model file fixes, then ``fix``, then ``free``; so ``fix=["*"], free=["coulomb"]``
    identifies friction alone.

    Args:
        free, fix: addresses (``bouc_wen#2.alpha``, ``viscous_curve.force[3]``), a whole vector
            (``viscous_curve.force``), a whole effect (``bouc_wen#2``), a parameter's name, or a pattern of
            these with ``*`` and ``?``.

    Raises:
        InputError: names every name that the model does not have, or says that nothing is left to identify.
    """
    free, fix = list(free), list(fix)
    _check_names(model, [*free, *fix])
    chosen = []
    for position, slot in enumerate(model.slots):
        fixed = slot.fixed or _named(slot, fix)
        if not fixed or _named(slot, free):
            chosen.append(position)
    if not chosen:
        raise InputError(f"model {model.name}: all its parameters are fixed; free some with --free NAME")
    return tuple(chosen)


def named_slots(model: DamperModel, names: Iterable[str]) -> tuple[int, ...]:
    """Positions in ``model.slots`` of the parameters that names mean, as in ``free_slots``.

    Raises:
        InputError: names every name that the model does not have.
    """
    names = list(names)
    _check_names(model, names)
    return tuple(i for i, slot in enumerate(model.slots) if _named(slot, names))


def narrowed(model: DamperModel, limits: Mapping[str, tuple[float, float]]) -> tuple[Slot, ...]:
    """The model's slots with narrower bounds, by names as in ``free_slots``; none becomes wider than declared.

    Raises:
        InputError: for an unknown name, and where no value is left between the bounds.
    """
    _check_names(model, list(limits))
    slots = list(model.slots)
    for name, (low, high) in limits.items():
        for i in named_slots(model, [name]):
            declared = slots[i].parameter
            lower, upper = max(low, declared.lower), min(high, declared.upper)
            if not lower < upper:
                raise InputError(
                    f"{slots[i].address}: nothing lies between {low:g} and {high:g} {declared.unit} and within its "
                    f"bounds {declared.lower:g} to {declared.upper:g}"
                )
            slots[i] = replace(slots[i], parameter=replace(declared, lower=lower, upper=upper))
    return tuple(slots)


def _check_names(model: DamperModel, names: list[str]) -> None:
    unknown = [name for name in names if not any(_named(slot, [name]) for slot in model.slots)]
    if unknown:
        addresses = [slot.address for slot in model.slots]
        near = did_you_mean(unknown[0], addresses) or f"; it has {', '.join(addresses)}"
        raise InputError(f"model {model.name}: has no parameter {', '.join(unknown)}{near}")


def _named(slot: Slot, names: list[str]) -> bool:
    vector = slot.address.split("[")[0]
    known = (slot.address, vector, vector.rpartition(".")[0], slot.parameter.name)
    # Brackets are part of an address, so only * and ? are patterns here.
    return any(word in known or any(fnmatchcase(k, word.replace("[", "[[]")) for k in known) for word in names)
