"""Assignments of one function in C: to numbers, elements and slices of arrays, and new names for these."""

import ast

from damper_estimator.codegen.context import Context
from damper_estimator.codegen.expressions import Expressions
from damper_estimator.codegen.values import INT, Array, Group, Number, Record, Value, joined, whole

_AUGMENTED = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


class Assignments:
    """Writes the assignments of one function; final."""

    def __init__(self, context: Context, expressions: Expressions):
        self._context = context
        self._expressions = expressions

    def augmented(self, node: ast.AugAssign) -> None:
        """``target += value`` and similar operators."""
        if isinstance(node.target, ast.Subscript):
            target = self._expressions.value(node.target)
            if isinstance(target, Array):
                self._each(node, target, self._expressions.value(node.value), _AUGMENTED[type(node.op)] + "=")
                return
            self._note_written(node.target)
        else:
            target = self._expressions.number(node.target)
        operation = ast.BinOp(node.target, node.op, node.value)
        result = self._expressions.number(ast.copy_location(operation, node))
        if isinstance(node.target, ast.Name):
            self._set_name(node, node.target.id, result, node)
            return
        number = self._expressions.number(node.value)
        sign = _AUGMENTED.get(type(node.op))
        if sign is None or result.kind != target.kind:
            self._context.emit(f"{target.code} = {self._context.cast(result, target.kind).code};")
            return
        self._context.emit(f"{target.code} {sign}= {self._context.cast(number, target.kind).code};")

    def assign(self, node: ast.Assign) -> None:
        """``target = value``, with several targets or values."""
        if isinstance(node.targets[0], ast.Tuple):
            self._several(node)
            return
        made = self._expressions.new_array(node.value)
        if made is not None:
            self._new_array(node, node.targets[0], *made)
            return
        value = self._expressions.value(node.value)
        targets = node.targets
        if len(targets) > 1 and isinstance(value, Number) and value.constant is None:
            value = self._temporary(value)
        for target in targets:
            self._store(node, target, value)

    def _several(self, node: ast.Assign) -> None:
        """``a, b = c, d``: with temporaries if an earlier target occurs in a later value."""
        targets = node.targets[0].elts
        if isinstance(node.value, ast.Tuple):
            made = [self._expressions.new_array(item) for item in node.value.elts]
            if all(made):
                for target, one in zip(targets, made, strict=True):
                    self._new_array(node, target, *one)
                return
        value = self._expressions.value(node.value)
        if not isinstance(value, Group) or len(value.items) != len(targets):
            raise self._context.error(node, f"{ast.unparse(node)}: the two sides do not match")
        items = list(value.items)
        if _interfere(targets, node.value):
            items = [self._temporary(i) if isinstance(i, Number) and i.constant is None else i for i in items]
        for target, item in zip(targets, items, strict=True):
            self._store(node, target, item)

    def _temporary(self, number: Number) -> Number:
        name = self._context.temporary("kept")
        self._context.emit(f"const {self._context.c_type(number.kind)} {name} = {number.code};")
        return Number(number.kind, name)

    def _store(self, node: ast.Assign, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            if isinstance(value, Number):
                self._set_name(node, target.id, value, node)
            else:
                self._bind(node, target.id, value)
            return
        place = self._expressions.value(target)
        if isinstance(place, Array):
            self._each(node, place, value, "=")
        elif isinstance(place, Number) and isinstance(value, Number):
            self._note_written(target)
            self._context.emit(f"{place.code} = {self._context.cast(value, place.kind).code};")
        else:
            raise self._context.error(node, f"{ast.unparse(node)} has no counterpart")

    def _note_written(self, target: ast.Subscript) -> None:
        owner = self._expressions.value(target.value)
        if not isinstance(owner, Array | Record):
            raise self._context.error(target, f"{ast.unparse(target)} cannot be changed")
        self._context.facts.write(owner.roots)

    def _set_name(self, node: ast.stmt, name: str, value: Number, binder: ast.stmt) -> None:
        context, uses = self._context, self._context.uses[name]
        if uses.stores == 1 and value.constant is not None and name not in context.names:
            context.names[name] = value
            return
        known = context.names.get(name)
        if known is not None:
            self._set_parameter(node, known, value)
            return
        kind = context.learn(name, value.kind)
        code = context.cast(value, kind).code
        if uses.declared_at() is binder:
            const = "const " if uses.stores == 1 else ""
            context.emit(f"{const}{context.c_type(kind)} {context.c_name(name)} = {code};")
            return
        if uses.declared_at() is None:
            self.hoist(name, kind)
        context.emit(f"{context.c_name(name)} = {code};")

    def _set_parameter(self, node: ast.stmt, known: Value, value: Number) -> None:
        if not isinstance(known, Number) or known.constant is not None or joined(known.kind, value.kind) != known.kind:
            raise self._context.error(node, f"{ast.unparse(node)}: an argument changes its kind")
        self._context.emit(f"{known.code} = {self._context.cast(value, known.kind).code};")

    def hoist(self, name: str, kind: str) -> None:
        """Declares a local number at the beginning of the function."""
        zero = self._context.cast(whole(0), kind).code
        self._context.hoisted[name] = f"{self._context.c_type(kind)} {self._context.c_name(name)} = {zero};"

    def _bind(self, node: ast.stmt, name: str, value: Value) -> None:
        """A local name for a part of an array, a record or a known value."""
        context = self._context
        if context.uses[name].stores != 1 or name in context.names:
            raise context.error(node, f"{name} refers to several arrays")
        if not isinstance(value, Array):
            context.names[name] = value
            return
        code = context.c_name(name)
        const = "" if name in context.facts.written else "const "
        context.facts.aliases[name] = value.roots
        if name in context.facts.written:
            context.facts.write(value.roots)
        if context.uses[name].declared_at() is not node:
            raise context.error(node, f"{name} is used outside the block in which it is created")
        context.emit(f"{const}{context.c_type(value.kind)} *{code} = {value.pointer};")
        dims = value.dims
        if not value.is_static:
            context.emit(f"const int32_t {code}_size = {value.dims[0]};")
            dims = (f"{code}_size",)
        context.names[name] = Array(value.kind, code, whole(0), dims, frozenset({name}))

    def _new_array(
        self, node: ast.Assign, target: ast.expr, kind: str, dims: tuple[int, ...], filling: Number | None
    ) -> None:
        context = self._context
        if not isinstance(target, ast.Name) or context.uses[target.id].stores != 1:
            raise context.error(node, "a new array needs a new name")
        if context.uses[target.id].declared_at() is not node:
            raise context.error(node, f"{target.id} is used outside the block in which it is created")
        code = context.c_name(target.id)
        array = Array(kind, code, whole(0), dims, frozenset())
        is_zero = filling is not None and filling.constant == 0
        context.emit(f"{context.c_type(kind)} {code}[{max(int(array.size), 1)}]{' = { 0 }' if is_zero else ''};")
        context.names[target.id] = array
        if filling is not None and not is_zero:
            self._each(node, array, filling, "=")

    def _each(self, node: ast.stmt, place: Array, value: Value, sign: str) -> None:
        """``place[:] = value``, element by element; the value is a number or an array of the same length."""
        context = self._context
        context.facts.write(place.roots)
        if isinstance(value, Array):
            if value.kind != place.kind or (value.is_static and place.is_static and value.size != place.size):
                raise context.error(node, f"{ast.unparse(node)}: the two sides differ in size")
        elif not isinstance(value, Number):
            raise context.error(node, f"{ast.unparse(node)} has no counterpart")
        if place.size == 1:
            item = Number(place.kind, f"{value.base}[{value.offset.code}]") if isinstance(value, Array) else value
            context.emit(f"{place.base}[{place.offset.code}] {sign} {context.cast(item, place.kind).code};")
            return
        turn = context.temporary("k")
        size = place.size if isinstance(place.size, int) or place.size.isidentifier() else f"({place.size})"
        context.emit(f"for (int32_t {turn} = 0; {turn} < {size}; ++{turn}) {{")
        left = self._expressions._sum(place.offset, Number(INT, turn)).code
        if isinstance(value, Array):
            right = f"{value.base}[{self._expressions._sum(value.offset, Number(INT, turn)).code}]"
        else:
            right = context.cast(value, place.kind).code
        context.emit(f"    {place.base}[{left}] {sign} {right};")
        context.emit("}")


def _interfere(targets: list[ast.expr], value: ast.expr) -> bool:
    """Whether a value uses a target that is set before the value is read."""
    values = value.elts if isinstance(value, ast.Tuple) else [value] * len(targets)
    for i, target in enumerate(targets):
        base = target
        while isinstance(base, ast.Subscript):
            base = base.value
        later = (
            n
            for part in (*values[i + 1 :], *(values[i:] if isinstance(value, ast.IfExp) else ()))
            for n in ast.walk(part)
        )
        if isinstance(base, ast.Name) and any(isinstance(n, ast.Name) and n.id == base.id for n in later):
            return True
    return False
