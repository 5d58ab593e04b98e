"""A function in C: its head, its comment and the arguments of its calls."""

import inspect
import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from damper_estimator.codegen.calls import leaves
from damper_estimator.codegen.values import Array, Group, Record, Value

if TYPE_CHECKING:
    from damper_estimator.codegen.translator import Translator

NAMES = re.compile(r"[A-Za-z_]\w*")
_DECLARED = re.compile(r"\s+(const )?(bool|u?int\d+_t|double|float) \*?(?P<name>\w+)(\[\d+\])?( = (?!.*\w\().*)?;$")
_WIDTH = 120


@dataclass(frozen=True)
class CFunction:
    """A translated function.

    Attributes:
        passed: for every leaf of the arguments in order, whether it is passed (because the function uses it), and the
            same for its length.
        written: for every leaf, whether its elements are changed.
        result: kinds of the returned numbers; None if nothing is returned.
        calls: names of the functions and tables that occur in it.
    """

    name: str
    text: str
    passed: tuple[tuple[bool, bool], ...]
    written: tuple[bool, ...]
    result: tuple[str, ...] | None
    calls: frozenset[str]


def finished(
    translator: "Translator", name: str, comment: str, parameters: list[Value], lines: list[str], written: set[str],
    result: tuple[str, ...] | None,
) -> CFunction:  # fmt: skip
    """A function from its lines: only names that occur in them become parameters."""
    lines = _without_unused(lines)
    occurring = set(NAMES.findall("\n".join(lines)))
    declared, passed = [], []
    flat = leaves(Group(tuple(parameters)))
    for leaf in flat:
        leaf_name = leaf.base if isinstance(leaf, Array) else leaf.code
        is_passed = leaf_name in occurring
        is_sized = isinstance(leaf, Array) and not leaf.is_static and f"{leaf_name}_size" in occurring
        passed.append((is_passed, is_sized))
        if is_passed:
            declared.append(_declaration(translator, leaf, leaf_name, leaf_name in written))
        if is_sized:
            declared.append(f"int32_t {leaf_name}_size")
    kind = (
        "void"
        if result is None
        else translator.c_type(result[0])
        if len(result) == 1
        else translator.result_type(result)
    )
    head = _wrapped(f"static {kind} {name}(", declared or ["void"])
    text = "\n".join([*filter(None, [comment]), head, "{", *lines, "}"])
    changed = tuple(isinstance(leaf, Array | Record) and bool(leaf.roots & written) for leaf in flat)
    return CFunction(name, text, tuple(passed), changed, result, frozenset(occurring))


def _wrapped(begin: str, declared: list[str]) -> str:
    """A function's head on as many lines as it needs."""
    lines = [begin]
    for i, item in enumerate(declared):
        item += ")" if i + 1 == len(declared) else ","
        gap = "" if lines[-1].endswith("(") else " "
        if len(lines[-1]) + len(gap) + len(item) > _WIDTH:
            lines.append("    ")
            gap = ""
        lines[-1] += gap + item
    return "\n".join(lines)


def _declaration(translator: "Translator", leaf: Value, name: str, is_written: bool) -> str:
    const = "" if is_written else "const "
    if isinstance(leaf, Record):
        return f"{const}{translator.struct_name(leaf.dtype)} *{name}"
    if isinstance(leaf, Array):
        return f"{const}{translator.c_type(leaf.kind)} *{name}"
    return f"{translator.c_type(leaf.kind)} {name}"


def _without_unused(lines: list[str]) -> list[str]:
    """The lines without declarations of names that only an excluded branch would have used."""
    while True:
        counts = Counter(NAMES.findall("\n".join(lines)))
        kept = [line for line in lines if not ((declared := _DECLARED.match(line)) and counts[declared["name"]] == 1)]
        if len(kept) == len(lines):
            return lines
        lines = kept


def comment_of(function: Callable) -> str:
    """The docstring of a function; for a kernel that of its file: equation, units, source."""
    is_kernel = function.__name__ == "kernel"
    text = (inspect.getmodule(function).__doc__ if is_kernel else function.__doc__) or ""
    text = inspect.cleandoc(text)
    return comment(text if is_kernel else text.split("\n\n")[0]) if text else ""


def comment(text: str) -> str:
    """Text as a C comment, in ASCII."""
    for sign, apart in (("*/", "* /"), ("/*", "/ *"), ("//", "/ /")):
        text = text.replace(sign, apart)
    lines = text.encode("ascii", "replace").decode().splitlines()
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in lines), " */"])
