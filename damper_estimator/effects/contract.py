"""The declaration of an effect: one physical phenomenon, in one file as ``EFFECT = Effect(...)``.

The kernel works on a block of samples, in place:

    kernel(parameters, settings, kinematics, state, force)

with contiguous float64 arrays ``parameters`` (p,), ``settings`` (s,), ``kinematics`` (8, n) in the rows of
``signals.layout``, ``state`` (z,) zero at the start and carried from block to block, ``force`` (n,) in N. A
sample with step 0 is the first after a reset. Live, a block has one sample; the same kernel runs live and offline.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import prod
from typing import Literal

import numpy as np

from damper_estimator.effects.trial import Try, ordinary

Kind = Literal["source", "modifier", "input", "series", "channel", "path", "scaled"]
Kernel = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], None]
Values = Mapping[str, float | tuple[float, ...]]


def number(values: Values, name: str) -> float:
    """The value of a scalar parameter or setting."""
    value = values[name]
    assert not isinstance(value, tuple), name
    return value


def numbers(values: Values, name: str) -> tuple[float, ...]:
    """The value of a vector parameter or list setting."""
    value = values[name]
    assert isinstance(value, tuple), name
    return value


KINDS: dict[str, str] = {
    "source": "adds force",
    "modifier": "rewrites the force of the effects before it",
    "input": "rewrites the motion or the slow channels for the effects after it in its path",
    "series": "wraps a path behind a compliance; the kernel is its force over deflection (X) and deflection rate (V)",
    "channel": "acts on the recording, offline only; corrected in the signal map",
    "path": "a separate force that is added to its parent",
    "scaled": "first in the path of a series effect: modifiers that scale the series effect itself",
}


@dataclass(frozen=True)
class Parameter:
    """A number that identification can change.

    Attributes:
        linear: the effect's force is proportional to the effect's linear parameters taken together.
        size: the list setting whose length a vector parameter has, or several for a grid; None for a scalar.
    """

    name: str
    unit: str
    default: float
    lower: float
    upper: float
    meaning: str
    linear: bool = False
    size: str | tuple[str, ...] | None = None

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the settings that determine its length; empty for a scalar."""
        return (self.size,) if isinstance(self.size, str) else self.size or ()

    def length(self, settings: Values) -> int | None:
        """Number of elements, given the settings by name; None for a scalar."""
        return None if self.size is None else prod(len(numbers(settings, name)) for name in self.axes)


@dataclass(frozen=True)
class Setting:
    """A number, list or word that the model file sets and identification never changes.

    Attributes:
        default: a float, or a tuple for a list; its type is the type that the model file must use.
        increasing: a list must be strictly increasing.
        adds: an otherwise linear effect is linear only where it is zero; else it adds a force.
    """

    name: str
    unit: str
    default: float | tuple[float, ...]
    meaning: str
    lower: float = -float("inf")
    upper: float = float("inf")
    increasing: bool = False
    adds: bool = False


KEPT_AT_REST = Setting("at_rest", "N", 0.0, "force at rest, which keeps its value", adds=True)


def flat(parameters: Values, settings: Values) -> np.ndarray:
    """The usual preparation: the settings in order, lists flattened."""
    return np.concatenate([np.atleast_1d(np.asarray(value, float)) for value in settings.values()] or [np.zeros(0)])


@dataclass(frozen=True)
class Effect:
    """Declaration of one effect; the name and the description are its file's name and docstring.

    Attributes:
        kernel: see the module's docstring; None for a bare path.
        phenomenon: the name that findings use, "" for a baseline that is never a finding.
        tests: names of the form-free tests of the diagnosis that reveal it (``diagnosis.atlas_terms``); empty if none
            is specific to it.
        states: number of states the kernel carries.
        prepare: (parameters, settings) by name to the kernel's settings array, called once per parameter set.
        linear: for modifiers: the result is linear in the force before it.
        order: declared order of convergence with the step; 0 without state.
        shows: how the effect appears in measurements, in words that can be checked on a plot.
        separate: the test that distinguishes it from similar effects.
        trial: how the search for missing effects tries it; None if it represents no single phenomenon (a whole damper
            in one formula).
        correct: for channel effects: returns the corrected numbers of the force channel (``scale``, ``offset``,
            ``skew``, ``spring_rate``, ``preload``), given the effect's values and the present numbers.
        of_oil: for series springs: the oil's, which carries the pressure difference over the piston alone; for input
            effects: they change the flow of the oil, not the motion of the damper.
        beside_oil: for sources: a force on the rod that is no pressure difference over the piston, as that of the gas.
        general: it can imitate more specific effects, so it is a finding only if it explains clearly more.
    """

    kernel: Kernel | None
    kind: Kind
    phenomenon: str = ""
    tests: tuple[str, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    settings: tuple[Setting, ...] = ()
    states: int = 0
    prepare: Callable[[Values, Values], np.ndarray] = flat
    linear: bool = True
    order: int = 0
    shows: str = ""
    separate: str = ""
    trial: Try | None = ordinary
    correct: Callable[[Values, Mapping[str, float]], dict[str, float]] | None = None
    of_oil: bool = False
    beside_oil: bool = False
    general: bool = False
    name: str = ""
    description: str = ""

    @property
    def is_series_spring(self) -> bool:
        """Whether it is a compliance with a stiffness: oil, mount, joint."""
        return self.kind == "series" and any(parameter.unit == "N/m" for parameter in self.parameters)

    @property
    def velocity_axes(self) -> tuple[str, ...]:
        """Settings that are knots over velocity, of both directions."""
        return tuple(s.name for s in self.settings if s.increasing and s.unit == "m/s" and s.lower < 0.0)

    @property
    def is_free_curve(self) -> bool:
        """Whether it follows any force over velocity, as a table that one linear parameter fills."""
        sizes = tuple(parameter.size for parameter in self.parameters if parameter.linear)
        return self.kind == "source" and len(sizes) == 1 and sizes == self.velocity_axes

    @property
    def delays(self) -> bool:
        """Whether it is a modifier that only delays: a constant force passes."""
        return self.kind == "modifier" and self.linear and self.states > 0

    def parameter(self, name: str) -> Parameter:
        """The declaration of a parameter; KeyError for an unknown name."""
        return {parameter.name: parameter for parameter in self.parameters}[name]
