"""Translates functions of the restricted Python in which kernels are written to C99, once per kind of arguments.

The language: functions over contiguous arrays of numbers, records (structured arrays' elements), numbers and tuples of
these; assignments, ``if``, ``while``, ``for`` over a range; the mathematical functions of ``calls``. Locals have the
kind of their values. Values known at translation (functions, tables, module constants, array sizes) are folded, and
branches that they exclude are omitted. Other constructs are refused with the function's name and line.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable

import numpy as np

from damper_estimator.codegen.c_function import CFunction, comment_of, finished
from damper_estimator.codegen.calls import leaves
from damper_estimator.codegen.context import Context, Facts
from damper_estimator.codegen.scope import uses_of
from damper_estimator.codegen.statements import Statements
from damper_estimator.codegen.values import (
    C_TYPES,
    INT,
    REAL,
    Array,
    Constant,
    Group,
    Number,
    Record,
    Untranslatable,
    Value,
    type_key,
    whole,
)
from damper_estimator.compiled import plain

_PASSES = 8

# By module: constants that double precision reaches and single precision does not.
SINGLE_PRECISION = {"damper_estimator.model.chain": {"_TOLERANCE": 1e-6, "_CLOSED": 1e-10}}


class Translator:
    """Collects the C functions of one source file; final.

    Attributes:
        real: C type of Python's floats; ``suffix`` the ending of its literals and functions.
    """

    def __init__(self, single: bool = False):
        """``single`` for single precision."""
        self.real, self.suffix = ("float", "f") if single else ("double", "")
        self._functions: dict[object, CFunction] = {}
        self._tables: dict[int, tuple[np.ndarray, Array]] = {}
        self._structs: dict[str, str] = {}
        self._results: dict[tuple[str, ...], str] = {}
        self._kept: list[object] = []  # objects that are distinguished by identity must live as long
        self._underway: list[object] = []
        self._replaced = SINGLE_PRECISION if single else {}

    def struct(self, dtype: np.dtype, name: str) -> None:
        """Sets the C name of the struct of a record's type."""
        self._structs[str(dtype)] = name

    def struct_name(self, dtype: np.dtype) -> str:
        """The C name of a record's type."""
        return self._structs[str(dtype)]

    def table(self, values: np.ndarray) -> Array:
        """A constant array of the source file."""
        if id(values) not in self._tables:
            kind = REAL if values.dtype.kind == "f" else INT
            name = f"table_{len(self._tables) + 1}"
            self._tables[id(values)] = values, Array(kind, name, whole(0), values.shape, frozenset())
        return self._tables[id(values)][1]

    def result_type(self, kinds: tuple[str, ...]) -> str:
        """The struct for several returned numbers."""
        return self._results.setdefault(kinds, "_".join(("pair" if len(kinds) == 2 else "group", *kinds)))

    def c_type(self, kind: str) -> str:
        """The C type of a kind."""
        return self.real if kind == REAL else C_TYPES[kind]

    def call(self, caller: Context, function: Callable, arguments: list[Value]) -> Value:
        """A call from within another function, which is translated first."""
        return self._called(caller, self.function(function, arguments), arguments)

    def function(self, function: Callable, arguments: list[Value]) -> CFunction:
        """The translation of a function for such arguments.

        Raises:
            Untranslatable: with the function's name, the line and the construct without counterpart.
        """
        key = (function, *(type_key(argument) for argument in arguments))
        if key in self._underway:
            raise Untranslatable(f"{function.__name__}: calls itself")
        if key not in self._functions:
            self._kept += [argument.value for argument in arguments if isinstance(argument, Constant)]
            self._underway.append(key)
            self._functions[key] = self._translated(function, arguments, self._new_name(function))
            self._underway.pop()
        return self._functions[key]

    def call_one_of(self, caller: Context, functions: tuple, number: Number, arguments: list[Value]) -> Value:
        """A call of one of several functions that return nothing, by number; the call is a switch, so that all calls
        are known statically."""
        key = ("one of", id(functions), *(type_key(argument) for argument in arguments))
        if key not in self._functions:
            self._kept.append(functions)
            self._functions[key] = self._switch(functions, arguments)
        return self._called(caller, self._functions[key], [number, *arguments])

    def _switch(self, functions: tuple, arguments: list[Value]) -> CFunction:
        inner = [Number(INT, "which"), *self._parameters([f"p{i}" for i in range(len(arguments))], arguments)]
        cases: dict[str, list[int]] = {}
        written: set[str] = set()
        lines = ["    switch (which) {"]
        for number, function in enumerate(functions):
            try:
                translated = self.function(plain(function), arguments)
            except Untranslatable as error:
                raise Untranslatable(f"effect {function.__module__.rsplit('.', 1)[-1]}: {error}") from error
            code = self.call_code(translated, inner[1:])
            cases.setdefault(code, []).append(number)
            passed = zip(leaves(Group(tuple(inner[1:]))), translated.written, strict=True)
            written |= {root for leaf, is_written in passed if is_written for root in getattr(leaf, "roots", ())}
        for code, numbers in cases.items():
            lines += [*(f"    case {n}:" for n in numbers), f"        {code};", "        break;"]
        lines += ["    default:", "        break;", "    }"]
        return finished(self, self._free("call_kernel"), "", inner, lines, written, None)

    def _called(self, caller: Context, called: CFunction, arguments: list[Value]) -> Value:
        for leaf, is_written in zip(leaves(Group(tuple(arguments))), called.written, strict=True):
            if is_written:
                caller.facts.write(leaf.roots)
        code = self.call_code(called, arguments)
        if called.result is None:
            caller.emit(f"{code};")
            return None
        if len(called.result) == 1:
            return Number(called.result[0], code)
        name = caller.temporary("found")
        caller.emit(f"const {self.result_type(called.result)} {name} = {code};")
        return Group(tuple(Number(kind, f"{name}.item_{i}") for i, kind in enumerate(called.result)))

    def call_code(self, called: CFunction, arguments: list[Value]) -> str:
        """The C expression of a call."""
        handed = []
        for leaf, (is_passed, is_sized) in zip(leaves(Group(tuple(arguments))), called.passed, strict=True):
            if is_passed:
                handed.append(leaf.pointer if isinstance(leaf, Array) else leaf.code)
            if is_sized:
                handed.append(str(leaf.size))
        return f"{called.name}({', '.join(handed)})"

    def _translated(self, function: Callable, arguments: list[Value], name: str) -> CFunction:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
        names = [argument.arg for argument in tree.args.args]
        if len(names) != len(arguments):
            raise Untranslatable(f"{function.__name__}: accepts {len(names)} arguments, got {len(arguments)}")
        facts, uses = Facts(), uses_of(tree)
        known = {**function.__globals__, **self._replaced.get(function.__module__, {})}
        for _ in range(_PASSES):
            before = facts.state()
            parameters = self._parameters(names, arguments)
            context = Context(self, function.__name__, known, uses, facts, dict(zip(names, parameters, strict=True)))
            Statements(context).block(tree.body)
            if facts.state() == before:
                break
        else:
            raise Untranslatable(f"{function.__name__}: the kinds of its names do not converge")
        lines = [f"    {line}" for line in context.hoisted.values()]
        return finished(
            self, name, comment_of(function), parameters, lines + context.lines, facts.written, facts.result
        )

    def _parameters(self, names: list[str], arguments: list[Value]) -> list[Value]:
        """The arguments as seen inside the function."""
        seen = []
        for name, argument in zip(names, arguments, strict=True):
            code = Context(self, "", {}, {}, Facts(), {}).c_name(name)
            if isinstance(argument, Number):
                seen.append(Number(argument.kind, code))
            elif isinstance(argument, Array):
                dims = tuple(dim if isinstance(dim, int) else f"{code}_size" for dim in argument.dims)
                seen.append(Array(argument.kind, code, whole(0), dims, frozenset({code})))
            elif isinstance(argument, Record):
                seen.append(Record(code, argument.dtype, frozenset({code})))
            elif isinstance(argument, Group):
                inner = [f"{name}_{i + 1}" for i in range(len(argument.items))]
                seen.append(Group(tuple(self._parameters(inner, list(argument.items)))))
            else:
                seen.append(argument)
        return seen

    def _new_name(self, function: Callable) -> str:
        module = function.__module__.rsplit(".", 1)[-1]
        return self._free(f"{module}_{function.__name__.strip('_')}")

    def _free(self, stem: str) -> str:
        taken = {function.name for function in self._functions.values()}
        return next(n for n in (stem, *(f"{stem}_{i}" for i in range(2, 1000))) if n not in taken)

    def source(self, roots: list[CFunction]) -> str:
        """The functions that ``roots`` need, each before its first call."""
        by_name = {function.name: function for function in self._functions.values()}
        order: list[str] = []

        def visit(function: CFunction) -> None:
            if function.name in order:
                return
            for called in sorted(function.calls & set(by_name) - {function.name}):
                visit(by_name[called])
            order.append(function.name)

        for root in roots:
            visit(root)
        texts = [by_name[n].text for n in order]
        used = frozenset().union(*(by_name[n].calls for n in order))
        return "\n\n".join([*self._result_types(used), *self._table_texts(used), *texts]) + "\n"

    def _result_types(self, used: frozenset[str]) -> list[str]:
        return [
            f"typedef struct {{ {' '.join(f'{self.c_type(k)} item_{i};' for i, k in enumerate(kinds))} }} {name};"
            for kinds, name in self._results.items()
            if name in used
        ]

    def _table_texts(self, used: frozenset[str]) -> list[str]:
        return [
            f"static const {self.c_type(table.kind)} {table.base}[{table.size}] = {{\n{rows(values)}\n}};"
            for values, table in self._tables.values()
            if table.base in used
        ]


def rows(values: np.ndarray) -> str:
    """The numbers of an integer table, one row per line."""
    lines = [", ".join(str(int(v)) for v in row) for row in np.atleast_2d(values)]
    return ",\n".join(f"    {line}" for line in lines)
