"""What a method of identification is: a search in a ``Problem``, declared in its file as ``METHOD = Method(...)``."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.identification import methods
from damper_estimator.identification.pareto_front import Front
from damper_estimator.identification.problem import Point, Problem


@dataclass(frozen=True)
class Solution:
    """Where a search ended.

    Attributes:
        point: the best one found.
        converged: whether the method's criterion was met.
        evaluations: runs of the model over all measurements of the problem, or their equal in samples.
        remark: a note on the search for the user, "" for none.
        front: the front of a method with several objectives; it contains the point.
    """

    point: Point
    converged: bool
    evaluations: int
    remark: str = ""
    front: Front | None = None


def _silent(text: str) -> None:
    """Tells nobody."""


@dataclass(frozen=True)
class MethodOptions:
    """A caller's requests to a search; a method uses those that concern it.

    Attributes:
        seed: of random draws; equal seeds return equal results.
        progress: receives a line from time to time.
        groups: objectives by name, each the recordings that it judges; empty forms them from the recordings.
        pick: which point of a front becomes the model: ``knee``, a group's name, or a number.
        front: points found before, among which one is picked without a search.
        gain: share of the cost; a local search ends where a step promises less. None for the method's default.
        generations, population: of evolutionary methods; None for the method's default.
    """

    seed: int = 0
    progress: Callable[[str], None] = _silent
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    pick: str = "knee"
    front: Front | None = None
    gain: float | None = None
    generations: int | None = None
    population: int | None = None


Search = Callable[[Problem, Problem, np.ndarray, np.ndarray, MethodOptions], Solution]


@dataclass(frozen=True)
class Method:
    """A method of identification.

    Attributes:
        search: (problem, sketch, candidates, size, options) to solution: the problem; the same on excerpts of the
            data, to try out cheaply; start candidates (s, q), the model's values first; magnitudes (q,) of the
            searched parameters; options of the method.
        several: whether it has several objectives, and so accepts groups and a choice from its front.
    """

    search: Search
    several: bool = False


@cache
def all_methods() -> dict[str, Method]:
    """Every method by name."""
    found = {}
    for module_info in sorted(iter_modules(methods.__path__), key=lambda info: info.name):
        declaration = vars(import_module(f"{methods.__name__}.{module_info.name}")).get("METHOD")
        if declaration is not None:
            found[module_info.name] = declaration
    return found


def find_method(name: str) -> Method:
    """The method of that name.

    Raises:
        InputError: for an unknown one, with all that there are.
    """
    if name not in all_methods():
        raise InputError(f"unknown method {name!r}; there are {', '.join(all_methods())}")
    return all_methods()[name]
