"""From pattern types to a model structure that can be fitted: the rules of Lozoya-Santos et al., Tables 9 and 10.

Both tables say the same as two rules, which also hold for combinations that they leave out:
passive: types 3 and 5 in any band call for the squash with sgn(x), types 2, 5 and 6 for the squash with sgn(a);
semi-active: a hysteretic type (2, 3, 5, 6) in any band calls for the term in x beside the one in v.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from damper_estimator.model import DamperModel, load_model

STIFF_TYPES, INERTIAL_TYPES = frozenset({3, 5}), frozenset({2, 5, 6})
HYSTERETIC_TYPES = STIFF_TYPES | INERTIAL_TYPES
_LIBRARY = {
    (False, False): "simple", (True, False): "stiff_simple", (False, True): "inertial_simple", (True, True): "complete",
}  # fmt: skip
_TERMS = {
    "simple": "f_s", "stiff_simple": "f_s + f_h,z", "inertial_simple": "f_s + f_h,a", "complete": "f_s + f_h,z + f_h,a",
}  # fmt: skip


TABLE_10_READING = {1: 4, 2: 5, 3: 5}
"""Types that semi-active diagrams have by their shape and Table 10 does not know, as what it would call them:
with a yield but without hysteresis is 4, with hysteresis 5."""


@dataclass(frozen=True)
class Structure:
    """A model structure.

    Attributes:
        passive: ``simple``, ``inertial_simple``, ``stiff_simple`` or ``complete``.
        semi_active: ``simple``, ``complete``, or "" where nothing is known of a semi-active part.
        symmetric: one set of parameters for both directions.
        because: the rules applied, in words.
    """

    passive: str
    semi_active: str
    symmetric: bool
    because: str

    @property
    def library_name(self) -> str:
        """The published model that holds this structure."""
        return f"lozoya_santos_{self.passive}{'_symmetric' if self.symmetric else ''}"


def passive_structure(types: Iterable[int]) -> str:
    """Table 9: the structure for the pattern types found in the bands."""
    found = set(types)
    return _LIBRARY[bool(found & STIFF_TYPES), bool(found & INERTIAL_TYPES)]


def semi_active_structure(types: Iterable[int]) -> str:
    """Table 10: the semi-active part for its pattern types; "" for none."""
    found = set(types)
    if not found:
        return ""
    return "complete" if found & HYSTERETIC_TYPES else "simple"


def derive(passive: dict[str, int], semi_active: dict[str, int], symmetric: bool) -> Structure:
    """The structure for the types by band; bands without data do not take part."""
    name, active = passive_structure(passive.values()), semi_active_structure(semi_active.values())
    words = [f"passive types {_listed(passive)} make it {name.replace('_', ' ')}: {_TERMS[name]} (Table 9)"]
    if active:
        terms = "the terms in v and in x" if active == "complete" else "the term in v"
        words.append(f"semi-active types {_listed(semi_active)} make it {active}: {terms} (Table 10)")
    words.append(
        "one set of parameters for both directions" if symmetric else "parameters of its own for each direction"
    )
    return Structure(name, active, symmetric, "; ".join(words))


def _listed(types: dict[str, int]) -> str:
    return ", ".join(f"{kind} ({band})" for band, kind in types.items())


def structure_model(structure: Structure) -> DamperModel:
    """The structure as a model, all parameters free but the coil's lag; no semi-active part where there is none."""
    model = load_model(structure.library_name)
    if not structure.semi_active:
        for label in sorted({slot.address.split(".")[0] for slot in model.slots}, reverse=True):
            if label.startswith(("semi_active_squash", "command_lag")):
                model = model.without(label)
    lag = [slot.address for slot in model.slots if slot.address.startswith("command_lag")]
    stiffness = [
        slot.address
        for slot in model.slots
        if slot.address.startswith("semi_active_squash") and slot.address.endswith("stiffness")
    ]
    # The published values belong to another damper; its region of validity does too.
    fixed = (*lag, *(stiffness if structure.semi_active == "simple" else ()))
    return replace(model, fixed=fixed, fit={}, notes=f"{structure.because}.")
