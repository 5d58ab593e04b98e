"""Discovers the effects: every module of this package that declares an ``EFFECT``."""

from dataclasses import replace
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from damper_estimator import effects
from damper_estimator.effects.contract import Effect
from damper_estimator.errors import InputError, did_you_mean

PATH = Effect(kernel=None, kind="path", name="path", description="A separate force that is added to its parent.")
SCALED = Effect(
    kernel=None,
    kind="scaled",
    name="scaled",
    description="First in the path of a series effect: modifiers that scale the series effect itself.",
)
LISTS = {effect.name: effect for effect in (PATH, SCALED)}
"""Containers of effects, not effects themselves."""


@cache
def all_effects() -> dict[str, Effect]:
    """Every effect by name, in alphabetical order."""
    found = {}
    for module_info in sorted(iter_modules(effects.__path__), key=lambda info: info.name):
        module = import_module(f"{effects.__name__}.{module_info.name}")
        declaration = vars(module).get("EFFECT")
        if declaration is not None:
            found[module_info.name] = replace(declaration, name=module_info.name, description=module.__doc__ or "")
    return found


def find_effect(name: str) -> Effect:
    """The effect of that name.

    Raises:
        InputError: for an unknown name, with similar names.
    """
    if name in LISTS:
        return LISTS[name]
    try:
        return all_effects()[name]
    except KeyError:
        near = did_you_mean(name, all_effects())
        raise InputError(f"unknown effect {name!r}{near} (damper-estimator effects lists all)") from None
