"""Finds the verbs, runs the requested one, and reports errors that users can correct in one line."""

import argparse
import ast
import importlib
import sys
from collections.abc import Collection, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

from damper_estimator import __doc__ as PURPOSE
from damper_estimator import __version__
from damper_estimator.cli.closable_output import ClosableOutput
from damper_estimator.cli.output_check import check_outputs
from damper_estimator.errors import InputError, did_you_mean

PROGRAM = "damper-estimator"
DONE, UNUSABLE_INPUT, WRONG_USAGE, INTERRUPTED, OUTPUT_CLOSED = 0, 1, 2, 130, 141
_FOLDER = Path(__file__).parent


class Parser(argparse.ArgumentParser):
    """Rejects unknown options with a suggestion; final."""

    def parse_known_args(self, args=None, namespace=None):
        """As in argparse, but unknown arguments are reported by the parser of the verb instead of the caller."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            flags = [flag for action in self._actions for flag in action.option_strings]
            self.error(f"unknown: {' '.join(unknown)}{did_you_mean(unknown[0].partition('=')[0], flags)}")
        return found, unknown


def verbs() -> dict[str, str]:
    """Module names by verb: the files of this folder that define ``add_arguments`` and ``run``; none is imported."""
    modules = sorted(path.stem for path in _FOLDER.glob("*.py") if {"add_arguments", "run"} <= _functions(path))
    return {module.rstrip("_").replace("_", "-"): module for module in modules}


def main(words: Sequence[str] | None = None) -> int:
    """Runs one verb.

    Args:
        words: the command line after the program's name; None for that of the process.

    Returns:
        The exit status: 0 done, 1 unusable input or an internal error, 2 wrong usage, 130 interrupted, 141 the
        reader closed the output.
    """
    words = list(sys.argv[1:] if words is None else words)
    output, messages = ClosableOutput(sys.stdout), ClosableOutput(sys.stderr)
    with redirect_stdout(output), redirect_stderr(messages):
        status = _run(words)
        output.flush()
    return OUTPUT_CLOSED if status == DONE and (output.is_closed or messages.is_closed) else status


def _run(words: Sequence[str]) -> int:
    """The exit status of a verb; what users can correct, and bugs, are reported."""
    try:
        arguments = _parser(words).parse_args(words)
        check_outputs(arguments)
        return arguments.run(arguments)
    except InputError as error:
        return _refuse(error)
    except OSError as error:
        return _refuse(InputError(": ".join(str(part) for part in (error.filename, error.strerror or error) if part)))
    except KeyboardInterrupt:
        print(f"{PROGRAM}: interrupted", file=sys.stderr)
        return INTERRUPTED
    except Exception as error:  # a bug
        from damper_estimator.cli.internal_error import internal_error

        return _refuse(InputError(internal_error(error, words)))


def _refuse(error: InputError) -> int:
    print(f"{PROGRAM}: {error}", file=sys.stderr)
    return UNUSABLE_INPUT


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """The parser for these words: every verb with its help line, arguments only for the called verb."""
    known = verbs()
    wanted = next((word for word in words if not word.startswith("-")), None)
    parser = parser_of({wanted} & set(known))
    if wanted and wanted == words[0] and wanted not in known:
        parser.error(f"no verb {wanted!r}{did_you_mean(wanted, known)} ({PROGRAM} --help lists all)")
    return parser


def parser_of(wanted: Collection[str]) -> argparse.ArgumentParser:
    """The parser of the command line: every verb with its help line, arguments only for the ``wanted`` verbs."""
    parser = Parser(prog=PROGRAM, description=PURPOSE.partition("\n")[0], allow_abbrev=False)
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {__version__}")
    group = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for verb, name in verbs().items():
        text = _docstring(_FOLDER / f"{name}.py")
        child = group.add_parser(
            verb,
            help=text.partition("\n")[0].replace("%", "%%"),
            description=text,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        if verb in wanted:
            module = importlib.import_module(f"damper_estimator.cli.{name}")
            module.add_arguments(child)
            child.set_defaults(run=module.run)
            child.epilog = _in_help(vars(module).get("EXAMPLES", ()))
    return parser


def _in_help(examples: Sequence[str]) -> str:
    lines = [f"  {PROGRAM} {example}" for example in examples]
    return "\n".join(["examples:", *lines]).replace("%", "%%") if lines else ""


def _functions(path: Path) -> set[str]:
    return {node.name for node in _tree(path).body if isinstance(node, ast.FunctionDef)}


def _docstring(path: Path) -> str:
    return ast.get_docstring(_tree(path)) or ""


def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


if __name__ == "__main__":
    sys.exit(main())
