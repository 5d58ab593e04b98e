"""Names of a package whose modules are imported at first use."""

import ast
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path


def lazy_names(package: str, file: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package (PEP 562) that imports a name's module at its first use.

    The names are those that the package's ``if TYPE_CHECKING:`` block imports, so they are listed only once, where
    type checkers and editors see them.

    Args:
        package, file: its ``__name__`` and ``__file__``.
    """

    def find(name: str) -> object:
        module = None if name.startswith("__") else _type_checking_imports(file).get(name)
        if module is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(module), name)

    def names() -> list[str]:
        return sorted({*vars(import_module(package)), *_type_checking_imports(file)})

    return find, names


@cache
def _type_checking_imports(file: str) -> dict[str, str]:
    """Module by name."""
    blocks = [
        node
        for node in ast.parse(Path(file).read_text(encoding="utf-8")).body
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    ]
    return {
        alias.name: node.module or ""
        for block in blocks
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
