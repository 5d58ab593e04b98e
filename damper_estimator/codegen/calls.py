"""Calls: builtins, mathematical and a few NumPy functions become C, other functions are translated."""

import ast
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.codegen import support
from damper_estimator.codegen.context import Context
from damper_estimator.codegen.values import (
    ATOM,
    BOOL,
    INT,
    LONG,
    PRODUCT,
    REAL,
    Array,
    Constant,
    Group,
    Number,
    Record,
    Value,
    joined,
    kind_of,
    whole,
)
from damper_estimator.compiled import borrowed, plain
from damper_estimator.model.kernels import call_kernel, part

if TYPE_CHECKING:
    from damper_estimator.codegen.expressions import Expressions

# C99's math.h under the names of Python's math; single precision appends an f.
_MATH = {
    getattr(math, name): c_name
    for name, c_name in {
        "exp": "exp", "expm1": "expm1", "log": "log", "sqrt": "sqrt", "tanh": "tanh", "atan": "atan", "sin": "sin",
        "cos": "cos", "tan": "tan",
    }.items()
}  # fmt: skip
_TESTS = {np.isfinite: "isfinite", np.isnan: "isnan"}
_OPERATORS = {support.c_rest: "%", support.c_quotient: "/"}
_NEW = {np.empty: None, np.zeros: 0.0, np.empty_like: None, np.full: None}


class Calls:
    """Evaluates the calls of one function; final."""

    def __init__(self, context: Context, expressions: "Expressions"):
        self._context = context
        self._expressions = expressions

    def value(self, node: ast.Call) -> Value:
        """The value of a call; a function that returns several numbers is called immediately, into a temporary."""
        function = self._expressions.value(node.func)
        called = function.value if isinstance(function, Constant) else None
        if called is call_kernel:
            return self._call_kernel(node)
        if called is part:
            array, first, last = node.args
            cut = ast.Slice(first, last)
            return self._expressions.value(ast.copy_location(ast.Subscript(array, cut, ast.Load()), node))
        if called in _NEW:
            raise self._context.error(node, f"{ast.unparse(node)}: a new array needs a name")
        arguments = [self._expressions.value(item) for item in node.args]
        if called is np.searchsorted:
            called = self._searchsorted(node)
        elif called is np.interp:
            called = support.interpolated
        if called is borrowed:
            return arguments[0]
        if called in _MATH or called in _TESTS:
            return self._mathematical(called, arguments[0])
        if called in (min, max, abs, int, float, bool, len):
            return self._builtin(node, called, arguments)
        if called in _OPERATORS:
            one, other = arguments
            return Number(one.kind, f"{one.inside(PRODUCT)} {_OPERATORS[called]} {other.inside(ATOM)}", PRODUCT)
        if callable(called) and hasattr(plain(called), "__code__"):
            return self.translated(plain(called), arguments)
        raise self._context.error(node, f"{ast.unparse(node.func)} has no counterpart")

    def translated(self, function: Callable, arguments: list[Value]) -> Value:
        """A call of a function that is translated as well."""
        return self._context.translator.call(self._context, function, arguments)

    def _call_kernel(self, node: ast.Call) -> Value:
        """``call_kernel(functions, number, ...)``."""
        functions = self._expressions.value(node.args[0])
        if not (isinstance(functions, Constant) and isinstance(functions.value, tuple)):
            raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")
        number = self._context.cast(self._expressions.number(node.args[1]), INT)
        arguments = [self._expressions.value(item) for item in node.args[2:]]
        return self._context.translator.call_one_of(self._context, functions.value, number, arguments)

    def new_array(self, node: ast.Call) -> tuple[str, tuple[int, ...], Number | None] | None:
        """Kind, lengths and initial value (None: undefined) of an array that an expression creates; None if it creates
        none."""
        function = self._expressions.value(node.func)
        called = function.value if isinstance(function, Constant) else None
        if isinstance(called, list | dict) or called not in _NEW:
            return None
        shape = self._expressions.value(node.args[0])
        if isinstance(shape, Array):
            dims, kind = shape.dims, shape.kind
        else:
            numbers = shape.items if isinstance(shape, Group) else (shape,)
            dims = tuple(None if n.constant is None else int(n.constant) for n in numbers)
            types = node.args[2 if called is np.full else 1 :]
            kind = kind_of(np.dtype(self._expressions.value(types[0]).value)) if types else REAL
        if not all(isinstance(dim, int) for dim in dims):
            raise self._context.error(node, f"{ast.unparse(node)}: its size is not known at translation")
        if called is np.full:
            return kind, dims, self._context.cast(self._expressions.number(node.args[1]), kind)
        return kind, dims, self._context.cast(whole(0), kind) if called is np.zeros else None

    def power(self, base: Number, exponent: Number) -> Number:
        """``base ** exponent``: multiplications for an integer constant, as in the compiled code."""
        context = self._context
        if exponent.constant == 2 and exponent.kind != REAL:
            base = context.cast(base, REAL)
            if base.level == ATOM:
                return Number(REAL, f"{base.code} * {base.code}", PRODUCT)
            return self.translated(support.squared, [base])
        names = (context.cast(base, REAL).code, context.cast(exponent, REAL).code)
        return Number(REAL, f"pow{self._suffix}({', '.join(names)})")

    def prelude(self, name: str, kind: str, *numbers: Number) -> Number:
        """A call of one of the small functions of ``support`` on numbers of one kind."""
        return self.translated(getattr(support, name), [self._context.cast(n, kind) for n in numbers])

    @property
    def _suffix(self) -> str:
        return self._context.translator.suffix

    def _searchsorted(self, node: ast.Call) -> Callable:
        side = [keyword.value.value for keyword in node.keywords if keyword.arg == "side"]
        if side != ["right"]:
            raise self._context.error(node, "np.searchsorted: only side='right' has a counterpart")
        return support.place_right

    def _mathematical(self, function: Callable, argument: Number) -> Number:
        if function in _TESTS:
            code = argument.code
            return Number(BOOL, f"{_TESTS[function]}({code}) != 0", 3)
        return Number(REAL, f"{_MATH[function]}{self._suffix}({self._context.cast(argument, REAL).code})")

    def _builtin(self, node: ast.Call, function: Callable, arguments: list[Value]) -> Value:
        if function is len:
            return self._length(node, arguments[0])
        numbers = [n for n in arguments if isinstance(n, Number)]
        if len(numbers) != len(arguments):
            raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")
        first = numbers[0]
        if function in (float, bool):
            return self._context.cast(first, REAL if function is float else BOOL)
        if function is int:
            if first.kind != REAL:
                return self._context.cast(first, joined(first.kind, INT))
            return Number(LONG, f"whole_part({first.code})")
        kind = joined(INT, first.kind)
        for number in numbers[1:]:
            kind = joined(kind, number.kind)
        if function is abs:
            if kind == REAL:
                return Number(REAL, f"fabs{self._suffix}({first.code})")
            return self.prelude("magnitude", kind, first)
        result = numbers[0]
        for number in numbers[1:]:
            result = self.prelude("smaller" if function is min else "larger", kind, result, number)
        return result

    def _length(self, node: ast.Call, value: Value) -> Number:
        if isinstance(value, Constant):
            return whole(len(value.value))
        if isinstance(value, Array):
            return whole(value.dims[0]) if isinstance(value.dims[0], int) else Number(INT, value.dims[0])
        raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")


def leaves(value: Value) -> list[Value]:
    """The passed values: the items of a tuple, none for a value known at translation."""
    if isinstance(value, Group):
        return [leaf for item in value.items for leaf in leaves(item)]
    return [value] if isinstance(value, Number | Array | Record) else []
