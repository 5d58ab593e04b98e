"""Expressions: Python's syntax tree to C code with a kind."""

import ast
import operator
from types import ModuleType

import numpy as np

from damper_estimator.codegen.calls import Calls
from damper_estimator.codegen.context import Context
from damper_estimator.codegen.values import (
    AND,
    BOOL,
    COMPARISON,
    INT,
    LONG,
    OR,
    PRODUCT,
    REAL,
    SUM,
    TERNARY,
    UNARY,
    Array,
    Constant,
    Group,
    Number,
    Record,
    Value,
    joined,
    kind_of,
    type_key,
    whole,
)

_BINARY = {ast.Add: ("+", SUM, operator.add), ast.Sub: ("-", SUM, operator.sub), ast.Mult: ("*", PRODUCT, operator.mul)}
_COMPARE = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
_DECIDE = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip


class Expressions:
    """Evaluates expressions of one function; final."""

    def __init__(self, context: Context):
        self._context = context
        self._calls = Calls(context, self)

    def value(self, node: ast.expr) -> Value:
        """The value of an expression.

        Raises:
            Untranslatable: names the construct without counterpart.
        """
        way = getattr(self, f"_{type(node).__name__.lower()}", None)
        if way is None:
            raise self._context.error(node, f"{type(node).__name__} has no counterpart")
        return way(node)

    def number(self, node: ast.expr) -> Number:
        """The value of a scalar expression."""
        value = self.value(node)
        if not isinstance(value, Number):
            raise self._context.error(node, f"{ast.unparse(node)} is not a number")
        return value

    def truth(self, node: ast.expr) -> Number:
        """The expression as a condition."""
        return self._context.cast(self.number(node), BOOL)

    def array(self, node: ast.expr) -> Array:
        """The value of an array expression."""
        value = self.value(node)
        if not isinstance(value, Array):
            raise self._context.error(node, f"{ast.unparse(node)} is not an array")
        return value

    def new_array(self, node: ast.expr) -> tuple[str, tuple[int, ...], Number | None] | None:
        """Kind, lengths and initial value (None: undefined) of an array that an expression creates; None if it creates
        none."""
        return self._calls.new_array(node) if isinstance(node, ast.Call) else None

    def _constant(self, node: ast.Constant) -> Value:
        return Constant(node.value) if isinstance(node.value, str) else self._context.literal(node.value)

    def _name(self, node: ast.Name) -> Value:
        names, kinds = self._context.names, self._context.facts.kinds
        if node.id in names:
            return names[node.id]
        if node.id in kinds:
            return Number(kinds[node.id], self._context.c_name(node.id))
        return self._context.global_value(node.id, node)

    def _tuple(self, node: ast.Tuple) -> Group:
        return Group(tuple(self.value(item) for item in node.elts))

    def _attribute(self, node: ast.Attribute) -> Value:
        value = self.value(node.value)
        if isinstance(value, Constant) and isinstance(value.value, ModuleType):
            found = getattr(value.value, node.attr)
            return self._context.literal(found) if isinstance(found, bool | int | float) else Constant(found)
        if node.attr == "shape" and isinstance(value, Constant):
            return Group(tuple(whole(int(dim)) for dim in value.value.shape))
        if node.attr in ("size", "shape") and isinstance(value, Array):
            dims = tuple(whole(dim) if isinstance(dim, int) else Number(INT, dim) for dim in value.dims)
            if node.attr == "shape":
                return Group(dims)
            return whole(value.size) if value.is_static else dims[0]
        raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")

    def _binop(self, node: ast.BinOp) -> Number:
        left, right = self.number(node.left), self.number(node.right)
        cast, both = self._context.cast, left.constant is not None and right.constant is not None
        if isinstance(node.op, ast.Pow):
            return self._calls.power(left, right)
        if isinstance(node.op, ast.Div):
            if both:
                return self._context.literal(float(left.constant) / float(right.constant))
            divisor = cast(right, REAL).inside(UNARY)
            return Number(REAL, f"{cast(left, REAL).inside(PRODUCT)} / {divisor}", PRODUCT)
        if isinstance(node.op, ast.FloorDiv | ast.Mod) and REAL not in (left.kind, right.kind):
            function = operator.floordiv if isinstance(node.op, ast.FloorDiv) else operator.mod
            if both:
                return whole(function(left.constant, right.constant))
            name = "floor_divided" if isinstance(node.op, ast.FloorDiv) else "floor_rest"
            return self._calls.prelude(name, LONG if LONG in (left.kind, right.kind) else INT, left, right)
        if type(node.op) not in _BINARY:
            raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")
        sign, level, function = _BINARY[type(node.op)]
        kind = joined(joined(left.kind, right.kind), INT)
        if both:
            return self._context.literal(function(left.constant, right.constant))
        if sign == "+" and kind != REAL and 0 in (left.constant, right.constant):
            return cast(left if right.constant == 0 else right, kind)
        one, other = cast(left, kind), cast(right, kind)
        first = UNARY if level == SUM and one.level == PRODUCT else level  # readers need not know that * binds before +
        last = UNARY if level == SUM else level + 1
        return Number(kind, f"{one.inside(first)} {sign} {other.inside(last)}", level)

    def _unaryop(self, node: ast.UnaryOp) -> Number:
        if isinstance(node.op, ast.Not):
            truth = self.truth(node.operand)
            return (
                self._context.literal(not truth.constant) if truth.constant is not None
                else Number(BOOL, f"!{truth.inside(UNARY)}", UNARY)
            )  # fmt: skip
        if not isinstance(node.op, ast.USub):
            raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")
        number = self.number(node.operand)
        if number.constant is not None:
            return self._context.literal(-number.constant)
        return Number(number.kind, f"-{number.inside(UNARY + 1)}", UNARY)

    def _boolop(self, node: ast.BoolOp) -> Number:
        sign, level, ends = ("&&", AND, False) if isinstance(node.op, ast.And) else ("||", OR, True)
        parts = []
        for item in node.values:
            truth = self.truth(item)
            if truth.constant is None:
                parts.append(truth)
            elif bool(truth.constant) == ends:
                return self._context.literal(ends)
        if len(parts) < 2:
            return parts[0] if parts else self._context.literal(not ends)
        return Number(BOOL, f" {sign} ".join(part.inside(UNARY) for part in parts), level)

    def _compare(self, node: ast.Compare) -> Number:
        items = [self.number(item) for item in (node.left, *node.comparators)]
        parts = []
        for left, right, op in zip(items, items[1:], node.ops, strict=False):
            if type(op) not in _COMPARE:
                raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")
            parts.append(self._compared(left, right, _COMPARE[type(op)]))
        if len(parts) == 1:
            return parts[0]
        return Number(BOOL, " && ".join(part.inside(UNARY) for part in parts), AND)

    def _compared(self, left: Number, right: Number, sign: str) -> Number:
        if left.constant is not None and right.constant is not None:
            return self._context.literal(_DECIDE[sign](left.constant, right.constant))
        kind = joined(left.kind, right.kind)
        one, other = (self._context.cast(n, kind).inside(UNARY) for n in (left, right))
        return Number(BOOL, f"{one} {sign} {other}", COMPARISON)

    def _ifexp(self, node: ast.IfExp) -> Value:
        test = self.truth(node.test)
        if test.constant is not None:
            return self.value(node.body if test.constant else node.orelse)
        return self._chosen(node, test, self.value(node.body), self.value(node.orelse))

    def _chosen(self, node: ast.IfExp, test: Number, yes: Value, no: Value) -> Value:
        if isinstance(yes, Number) and isinstance(no, Number):
            kind = joined(yes.kind, no.kind)
            yes, no = self._context.cast(yes, kind), self._context.cast(no, kind)
            return Number(kind, f"{test.inside(UNARY)} ? {yes.inside(UNARY)} : {no.inside(UNARY)}", TERNARY)
        if isinstance(yes, Array) and isinstance(no, Array) and yes.is_static and type_key(yes) == type_key(no):
            code = f"({test.inside(UNARY)} ? {yes.pointer} : {no.pointer})"
            return Array(yes.kind, code, whole(0), yes.dims, yes.roots | no.roots)
        if isinstance(yes, Group) and isinstance(no, Group):
            pairs = zip(yes.items, no.items, strict=True)
            return Group(tuple(self._chosen(node, test, one, other) for one, other in pairs))
        raise self._context.error(node, f"{ast.unparse(node)}: the two sides differ")

    def _call(self, node: ast.Call) -> Value:
        return self._calls.value(node)

    def _subscript(self, node: ast.Subscript) -> Value:
        value = self.value(node.value)
        if isinstance(value, Record):
            return self._field(value, node.slice.value)
        if isinstance(value, Group):
            return value.items[int(self.number(node.slice).constant)]
        if isinstance(value, Constant) and isinstance(value.value, np.ndarray):
            value = self._context.translator.table(value.value)
        if isinstance(value, Array):
            return self._part(node, value)
        raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")

    def _field(self, record: Record, name: str) -> Value:
        dtype = record.dtype[name]
        if dtype.shape:
            return Array(kind_of(dtype.base), f"{record.code}->{name}", whole(0), dtype.shape, record.roots)
        return Number(kind_of(dtype), f"{record.code}->{name}")

    def _part(self, node: ast.Subscript, array: Array) -> Value:
        """An element, a row or a slice of an array."""
        indices = list(node.slice.elts) if isinstance(node.slice, ast.Tuple) else [node.slice]
        while indices and _is_whole(indices[-1]):  # a[i, :] is a[i]
            indices.pop()
        offset, dims = array.offset, list(array.dims)
        for index in indices:
            rest = int(np.prod(dims[1:], dtype=int)) if len(dims) > 1 else 1
            if isinstance(index, ast.Slice):
                if _is_whole(index) and all(
                    _is_whole(i) or dim == 1 for i, dim in zip(indices[1:], dims[1:], strict=False)
                ):
                    # a[:, i] of a single column: all of it
                    return Array(array.kind, array.base, offset, (dims[0],), array.roots)
                if len(dims) > 1:
                    raise self._context.error(node, f"{ast.unparse(node)}: only one dimension can be cut")
                first, size = self._stretch(index, dims[0])
                return Array(array.kind, array.base, self._sum(offset, first), (size,), array.roots)
            offset = self._sum(offset, self._product(self.number(index), rest))
            dims.pop(0)
        if dims:
            return Array(array.kind, array.base, offset, tuple(dims), array.roots)
        return Number(array.kind, f"{array.base}[{offset.code}]")

    def _stretch(self, cut: ast.Slice, length: int | str) -> tuple[Number, int | str]:
        """Start and length of a slice."""
        zero, end = whole(0), whole(length) if isinstance(length, int) else Number(INT, length)
        first = zero if cut.lower is None else self.number(cut.lower)
        if cut.upper is None:
            last = end
        elif isinstance(cut.upper, ast.BinOp) and isinstance(cut.upper.op, ast.Add) and cut.lower is not None \
                and ast.unparse(cut.upper.left) == ast.unparse(cut.lower):  # fmt: skip
            size = self.number(cut.upper.right)
            return first, self._length(size)
        else:
            last = self.number(cut.upper)
        if first.constant == 0:
            return first, self._length(last)
        if last.constant is not None and first.constant is not None:
            return first, int(last.constant - first.constant)
        code = f"{last.inside(UNARY)} - {first.inside(UNARY)}"
        return first, self._length(Number(joined(first.kind, last.kind), code, SUM))

    def _length(self, size: Number) -> int | str:
        return int(size.constant) if size.constant is not None else self._context.cast(size, INT).code

    def _sum(self, one: Number, other: Number) -> Number:
        if one.constant is not None and other.constant is not None:
            return whole(int(one.constant + other.constant))
        if one.constant == 0 or other.constant == 0:
            return other if one.constant == 0 else one
        first = one.code if one.level == SUM else one.inside(UNARY)
        return Number(joined(one.kind, other.kind), f"{first} + {other.inside(UNARY)}", SUM)

    def _product(self, number: Number, factor: int) -> Number:
        if number.constant is not None:
            return whole(int(number.constant) * factor)
        return number if factor == 1 else Number(number.kind, f"{number.inside(PRODUCT)} * {factor}", PRODUCT)


def _is_whole(index: ast.expr) -> bool:
    return isinstance(index, ast.Slice) and index.lower is None and index.upper is None
