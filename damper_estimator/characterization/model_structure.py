"""Derives a model structure from pattern types by the rules of Lozoya-Santos et al., Tables 9 and 10.

Both tables are equivalent to two rules, which also cover combinations missing there:
passive: types 3 and 5 in any band require the squash with sgn(x), types 2, 5 and 6 the squash with sgn(a);
semi-active: a hysteretic type (2, 3, 5, 6) in any band requires the term in x in addition to the one in v.
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
"""Types of semi-active diagrams that Table 10 does not contain, with their equivalents:
a yield without hysteresis is 4, with hysteresis 5."""


@dataclass(frozen=True)
class Structure:
    """A model structure.

    Attributes:
        passive: ``simple``, ``inertial_simple``, ``stiff_simple`` or ``complete``.
        semi_active: ``simple``, ``complete``, or "" if there is no semi-active part.
        symmetric: one set of parameters for both directions.
        because: the applied rules as text.
    """

    passive: str
    semi_active: str
    symmetric: bool
    because: str

    @property
    def library_name(self) -> str:
        """The published model with this structure."""
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
    """The structure for the types by band; bands without data are ignored."""
    name, active = passive_structure(passive.values()), semi_active_structure(semi_active.values())
    words = [f"passive types {_listed(passive)} make it {name.replace('_', ' ')}: {_TERMS[name]} (Table 9)"]
    if active:
        terms = "the terms in v and in x" if active == "complete" else "the term in v"
        words.append(f"semi-active types {_listed(semi_active)} make it {active}: {terms} (Table 10)")
    words.append("one set of parameters for both directions" if symmetric else "separate parameters for each direction")
    return Structure(name, active, symmetric, "; ".join(words))


def _listed(types: dict[str, int]) -> str:
    return ", ".join(f"{kind} ({band})" for band, kind in types.items())


def structure_model(structure: Structure) -> DamperModel:
    """The structure as a model, all parameters free except the coil's lag; the semi-active part only if known."""
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
    # Published values and region of validity belong to another damper.
    fixed = (*lag, *(stiffness if structure.semi_active == "simple" else ()))
    return replace(model, fixed=fixed, fit={}, notes=f"{structure.because}.")
