"""The state of the translation of one Python function: its names, written arrays and lines."""

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from damper_estimator.codegen.scope import Uses
from damper_estimator.codegen.values import (
    C_TYPES,
    REAL,
    UNARY,
    Constant,
    Number,
    Untranslatable,
    Value,
    joined,
    literal,
)

if TYPE_CHECKING:
    from damper_estimator.codegen.translator import Translator

_RESERVED = frozenset(
    [
        "auto",
        "bool",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "false",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "true",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
    ]
)


@dataclass
class Facts:
    """Results of one pass over a function for the next; passes repeat until they add nothing.

    Attributes:
        kinds: of local numbers.
        written: names of parameters and local arrays whose elements are changed.
        aliases: names that a local array can be a part of.
        result: kinds of the returned numbers; None if nothing is returned.
    """

    kinds: dict[str, str] = field(default_factory=dict)
    written: set[str] = field(default_factory=set)
    aliases: dict[str, frozenset[str]] = field(default_factory=dict)
    result: tuple[str, ...] | None = None

    def state(self) -> tuple:
        """For comparison."""
        return tuple(self.kinds.items()), frozenset(self.written), tuple(self.aliases), self.result

    def write(self, roots: frozenset[str]) -> None:
        """Notes that elements of these arrays are changed."""
        for root in roots - self.written:
            self.written.add(root)
            self.write(self.aliases.get(root, frozenset()))


@dataclass
class Context:
    """One pass over one function."""

    translator: "Translator"
    label: str
    globals: Mapping[str, object]
    uses: Mapping[str, Uses]
    facts: Facts
    names: dict[str, Value]
    lines: list[str] = field(default_factory=list)
    hoisted: dict[str, str] = field(default_factory=dict)
    depth: int = 1
    temporaries: int = 0

    def emit(self, line: str) -> None:
        """Adds a line at the current depth."""
        self.lines.append("    " * self.depth + line)

    def c_type(self, kind: str) -> str:
        """The C type of a kind."""
        return self.translator.real if kind == REAL else C_TYPES[kind]

    def literal(self, value: float) -> Number:
        """A constant."""
        return literal(value, self.translator.suffix)

    def cast(self, number: Number, kind: str) -> Number:
        """The number converted to another kind; never to a narrower one unless the source says so."""
        if number.kind == kind:
            return number
        if number.constant is not None:
            return self.literal({REAL: float, "bool": bool}.get(kind, int)(number.constant))
        if kind == "bool":
            return Number(
                kind, f"{number.inside(4)} != {'0.0' + self.translator.suffix if number.kind == REAL else '0'}", 3
            )
        return Number(kind, f"({self.c_type(kind)}){number.inside(UNARY)}", UNARY)

    def temporary(self, stem: str) -> str:
        """A new local name."""
        self.temporaries += 1
        return f"{stem}_{self.temporaries}"

    def c_name(self, name: str) -> str:
        """The C name of a local name; that of a ``_`` ends as no other does."""
        plain = name.strip("_")
        if not plain:
            return "turn_"
        return f"{plain}_" if plain in _RESERVED else plain

    def learn(self, name: str, kind: str) -> str:
        """The kind of a local number that is given a value of ``kind``."""
        self.facts.kinds[name] = joined(self.facts.kinds.get(name), kind)
        return self.facts.kinds[name]

    def global_value(self, name: str, node: ast.AST) -> Value:
        """The value of a name of the module or a builtin."""
        if name in self.globals:
            value = self.globals[name]
        elif name in BUILTINS:
            value = BUILTINS[name]
        else:
            raise self.error(node, f"{name!r} is used before it has a value")
        return self.literal(value) if isinstance(value, bool | int | float) else Constant(value)

    def error(self, node: ast.AST, reason: str) -> Untranslatable:
        """The exception for Python code that cannot be translated."""
        return Untranslatable(f"{self.label}: line {getattr(node, 'lineno', '?')}: {reason}")


BUILTINS = {function.__name__: function for function in (abs, min, max, int, float, bool, len, range)}
