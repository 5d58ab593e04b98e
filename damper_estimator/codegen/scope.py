"""Scopes of the local names of a Python function in C: Python's scope is the function, C's the block."""

import ast
from dataclasses import dataclass, field


@dataclass
class Uses:
    """Occurrences of a name in order of the source: path of blocks, and the statement that binds it or None."""

    paths: list[tuple[int, ...]] = field(default_factory=list)
    binders: list[ast.stmt | None] = field(default_factory=list)
    stores: int = 0

    def declared_at(self) -> ast.stmt | None:
        """The statement that can declare the name, because all other uses follow in its block or inside; None if it
        must be declared at the beginning of the function."""
        shortest = min(len(path) for path in self.paths)
        common = [steps[0] for steps in zip(*(path[:shortest] for path in self.paths), strict=True)
                  if len(set(steps)) == 1]  # fmt: skip
        return self.binders[0] if self.paths[0] == tuple(common) else None

    def belongs_to(self, loop: ast.For) -> bool:
        """Whether the name is only this loop's counter."""
        return all(binder is None or isinstance(binder, ast.For) for binder in self.binders) and self._within_loops()

    def _within_loops(self) -> bool:
        counted = {path for path, binder in zip(self.paths, self.binders, strict=True) if isinstance(binder, ast.For)}
        return all(any(path[: len(c)] == c for c in counted) for path in self.paths)


def uses_of(function: ast.FunctionDef) -> dict[str, Uses]:
    """The uses of every name of a function."""
    found: dict[str, Uses] = {}
    _visit_block(function.body, (0,), found, [1])
    return found


def _note(node: ast.AST, path: tuple[int, ...], found: dict[str, Uses], binder: ast.stmt | None = None) -> None:
    for name in (n for n in ast.walk(node) if isinstance(n, ast.Name)):
        uses = found.setdefault(name.id, Uses())
        stores = isinstance(name.ctx, ast.Store)
        uses.paths.append(path)
        uses.binders.append(binder if stores else None)
        uses.stores += stores


def _visit_block(body: list[ast.stmt], path: tuple[int, ...], found: dict[str, Uses], count: list[int]) -> None:
    for statement in body:
        if isinstance(statement, ast.Assign):
            _note(statement.value, path, found)
            for target in statement.targets:
                _note(target, path, found, statement)
        elif isinstance(statement, ast.AugAssign):
            _note(statement.value, path, found)
            _note(statement.target, path, found)
            if isinstance(statement.target, ast.Name):
                found[statement.target.id].stores += 1  # it is not a constant, whatever its first value
        elif isinstance(statement, ast.For):
            count[0] += 1
            inner = (*path, count[0])
            _note(statement.iter, path, found)
            _note(statement.target, inner, found, statement)
            _visit_block(statement.body, inner, found, count)
        elif isinstance(statement, ast.If | ast.While):
            _note(statement.test, path, found)
            for block in (statement.body, statement.orelse):
                count[0] += 1
                _visit_block(block, (*path, count[0]), found, count)
        else:
            _note(statement, path, found)
