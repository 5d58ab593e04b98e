"""Statements: branches, loops and returns of one function in C."""

import ast

from damper_estimator.codegen.assignments import Assignments
from damper_estimator.codegen.context import Context
from damper_estimator.codegen.expressions import Expressions
from damper_estimator.codegen.values import INT, Group, Number, joined, whole


class Statements:
    """Writes the statements of one function; final."""

    def __init__(self, context: Context):
        self._context = context
        self._expressions = Expressions(context)
        self._assignments = Assignments(context, self._expressions)

    def block(self, body: list[ast.stmt]) -> bool:
        """Writes statements in order; returns whether they always leave the function."""
        for statement in body:
            way = getattr(self, f"_{type(statement).__name__.lower()}", None)
            if way is None:
                raise self._context.error(statement, f"{type(statement).__name__} has no counterpart")
            if way(statement):
                return True
        return False

    def _inner(self, body: list[ast.stmt]) -> None:
        self._context.depth += 1
        self.block(body)
        self._context.depth -= 1

    def _expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant):
            return
        value = self._expressions.value(node.value)
        if value is not None:
            raise self._context.error(node, f"{ast.unparse(node)}: its value is not used")

    def _assign(self, node: ast.Assign) -> None:
        self._assignments.assign(node)

    def _augassign(self, node: ast.AugAssign) -> None:
        self._assignments.augmented(node)

    def _pass(self, node: ast.Pass) -> None:
        pass

    def _return(self, node: ast.Return) -> bool:
        facts = self._context.facts
        if node.value is None:
            self._context.emit("return;")
            return True
        value = self._expressions.value(node.value)
        numbers = value.items if isinstance(value, Group) else (value,)
        if not all(isinstance(number, Number) for number in numbers):
            raise self._context.error(node, "only numbers can be returned")
        before = facts.result or (None,) * len(numbers)
        facts.result = tuple(joined(kind, number.kind) for kind, number in zip(before, numbers, strict=True))
        codes = [self._context.cast(n, kind).code for n, kind in zip(numbers, facts.result, strict=True)]
        if len(codes) == 1:
            self._context.emit(f"return {codes[0]};")
            return True
        name = self._context.temporary("result")
        self._context.emit(
            f"const {self._context.translator.result_type(facts.result)} {name} = {{ {', '.join(codes)} }};"
        )
        self._context.emit(f"return {name};")
        return True

    def _break(self, node: ast.Break) -> bool:
        self._context.emit("break;")
        return True

    def _continue(self, node: ast.Continue) -> bool:
        self._context.emit("continue;")
        return True

    def _if(self, node: ast.If) -> bool:
        test = self._expressions.truth(node.test)
        if test.constant is not None:
            return self.block(node.body if test.constant else node.orelse)
        self._branches(node, test, "if")
        return False

    def _branches(self, node: ast.If, test: Number, word: str) -> None:
        self._context.emit(f"{word} ({test.code}) {{")
        self._inner(node.body)
        following = node.orelse
        if len(following) == 1 and isinstance(following[0], ast.If):
            other = self._expressions.truth(following[0].test)
            if other.constant is None:
                self._branches(following[0], other, "} else if")
                return
        if following:
            self._context.emit("} else {")
            self._inner(following)
        self._context.emit("}")

    def _while(self, node: ast.While) -> None:
        test = self._expressions.truth(node.test)
        if test.constant is not None and not test.constant:
            return
        self._context.emit(f"while ({test.code}) {{")
        self._inner(node.body)
        self._context.emit("}")

    def _for(self, node: ast.For) -> None:
        call = node.iter
        if not (isinstance(call, ast.Call) and getattr(call.func, "id", "") == "range" and 1 <= len(call.args) <= 2):
            raise self._context.error(node, f"{ast.unparse(call)}: only a range can be iterated")
        bounds = [self._expressions.number(item) for item in call.args]
        first, last = (whole(0), bounds[0]) if len(bounds) == 1 else bounds
        if not isinstance(node.target, ast.Name):
            raise self._context.error(node, f"{ast.unparse(node.target)}: a loop has one counter")
        turns = None if first.constant is None or last.constant is None else last.constant - first.constant
        if turns is not None and turns <= 0:
            return  # never executed
        if turns == 1 and not _leaves_turn(node):
            self._context.names[node.target.id] = first
            self.block(node.body)
            del self._context.names[node.target.id]
            return
        self._loop(node, first, last)

    def _loop(self, node: ast.For, first: Number, last: Number) -> None:
        context, name = self._context, node.target.id
        kind = joined(joined(first.kind, last.kind), INT)
        code = context.c_name(name)
        context.learn(name, kind)
        declared = context.uses[name].belongs_to(node)
        if not declared:
            self._assignments.hoist(name, kind)
        changed = {
            n.id
            for part in node.body
            for n in ast.walk(part)
            if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        }
        if last.constant is None and changed & {n.id for n in ast.walk(node.iter) if isinstance(n, ast.Name)}:
            raise context.error(node, "the loop's end is changed inside it")
        start = f"{context.c_type(kind) + ' ' if declared else ''}{code} = {context.cast(first, kind).code}"
        context.emit(f"for ({start}; {code} < {context.cast(last, kind).inside(6)}; ++{code}) {{")
        self._inner(node.body)
        context.emit("}")


def _leaves_turn(loop: ast.For) -> bool:
    """Whether a break or continue in a loop's body belongs to this loop."""

    def search(body: list[ast.stmt]) -> bool:
        for statement in body:
            if isinstance(statement, ast.Break | ast.Continue):
                return True
            if isinstance(statement, ast.If) and (search(statement.body) or search(statement.orelse)):
                return True
        return False

    return search(loop.body)
