"""Values of expressions of a translated function: a C expression with its kind, or a value known at translation.

Kinds of numbers rise from ``BOOL`` to ``REAL``; two kinds combine to the higher one. Python's integers are ``INT``
(32 bit) where they count or index, and ``LONG`` (64 bit) where they come from stamps or from a rounded number.
"""

from dataclasses import dataclass
from math import isfinite, isnan

import numpy as np

BOOL, BYTE, INT, LONG, REAL = KINDS = ("bool", "byte", "int", "long", "real")
C_TYPES = {BOOL: "bool", BYTE: "uint8_t", INT: "int32_t", LONG: "int64_t"}

# Precedence of C's operators, from low to high; an operand of lower precedence than its context gets parentheses.
TERNARY, OR, AND, COMPARISON, SUM, PRODUCT, UNARY, ATOM = range(8)


class Untranslatable(Exception):
    """Python code outside the restricted language; the message names function, line and reason."""


@dataclass(frozen=True)
class Number:
    """A scalar; ``constant`` is its value if known."""

    kind: str
    code: str
    level: int = ATOM
    constant: float | None = None

    def inside(self, level: int) -> str:
        """The code as an operand in a context of precedence ``level``."""
        return self.code if self.level >= level else f"({self.code})"


@dataclass(frozen=True)
class Array:
    """Contiguous elements: base[offset], base[offset + 1] ...

    Attributes:
        base: C expression of a pointer.
        dims: numbers, or a C expression for a length that is only known at run time (one dimension).
        roots: names of parameters and local arrays that the elements can belong to.
    """

    kind: str
    base: str
    offset: Number
    dims: tuple[int | str, ...]
    roots: frozenset[str]

    @property
    def pointer(self) -> str:
        """C expression of the address of the first element."""
        return self.base if self.offset.constant == 0 else f"&{self.base}[{self.offset.code}]"

    @property
    def size(self) -> int | str:
        """Number of elements."""
        return int(np.prod(self.dims)) if self.is_static else self.dims[0]

    @property
    def is_static(self) -> bool:
        """Whether all lengths are known."""
        return all(isinstance(dim, int) for dim in self.dims)


@dataclass(frozen=True)
class Record:
    """One element of a structured array: a pointer to a struct."""

    code: str
    dtype: np.dtype
    roots: frozenset[str]


@dataclass(frozen=True)
class Constant:
    """A function, a module, a table or a list that is known at translation."""

    value: object


@dataclass(frozen=True)
class Group:
    """A tuple."""

    items: tuple


Value = Number | Array | Record | Constant | Group


def joined(one: str | None, other: str) -> str:
    """The kind that can hold both."""
    return other if one is None else max(one, other, key=KINDS.index)


def kind_of(dtype: np.dtype) -> str:
    """Kind of an array's elements.

    Raises:
        Untranslatable: for any other element.
    """
    kinds = {"f8": REAL, "i8": LONG, "i4": INT, "u1": BYTE, "b1": BOOL}
    if dtype.str[1:] not in kinds:
        raise Untranslatable(f"elements of type {dtype} have no counterpart in C")
    return kinds[dtype.str[1:]]


def whole(value: int) -> Number:
    """An integer constant."""
    small = abs(value) < 2**31
    code = str(value) if small else f"INT64_C({value})"
    return Number(INT if small else LONG, code, ATOM if value >= 0 else UNARY, value)


def type_key(value: Value) -> object:
    """The key that selects the C function for such an argument."""
    if isinstance(value, Number):
        return value.kind
    if isinstance(value, Array):
        return value.kind, tuple(dim if isinstance(dim, int) else None for dim in value.dims)
    if isinstance(value, Record):
        return str(value.dtype)
    if isinstance(value, Group):
        return tuple(type_key(item) for item in value.items)
    return "constant", id(value.value)


def literal(value: float, suffix: str = "") -> Number:
    """A constant; ``suffix`` follows literals of single precision."""
    if isinstance(value, bool):
        return Number(BOOL, "true" if value else "false", constant=value)
    if isinstance(value, int):
        return whole(value)
    if not isfinite(value):
        code = "NAN" if isnan(value) else "INFINITY" if value > 0.0 else "-INFINITY"
    else:
        code = repr(float(value)) + suffix
    return Number(REAL, code, UNARY if code.startswith("-") else ATOM, value)
