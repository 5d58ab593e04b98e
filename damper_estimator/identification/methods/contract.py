"""What a method of identification is: a search in a ``Problem``, declared in its file as ``METHOD = Method(...)``."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.identification import methods
from damper_estimator.identification.problem import Point, Problem


@dataclass(frozen=True)
class Solution:
    """Where a search ended.

    Attributes:
        point: the best one found.
        converged: whether the method's own criterion was met.
        evaluations: runs of the model over all measurements of the problem, or their equal in samples.
        remark: what the user should know of the search, "" for nothing.
    """

    point: Point
    converged: bool
    evaluations: int
    remark: str = ""


Search = Callable[[Problem, Problem, np.ndarray, np.ndarray, int], Solution]


@dataclass(frozen=True)
class Method:
    """A method of identification.

    Attributes:
        search: (problem, sketch, candidates, size, seed) to solution: the problem; the same on excerpts of the
            data, to try out cheaply; start candidates (s, q), the model's own values first; magnitudes (q,) of the
            searched parameters; seed.
    """

    search: Search


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
