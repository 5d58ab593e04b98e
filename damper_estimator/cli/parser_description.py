"""The command line as data, extracted from its parsers, for shell completion and manual pages."""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from damper_estimator.cli.main import parser_of, verbs


@dataclass(frozen=True)
class Argument:
    """An option, or a positional argument.

    Attributes:
        flags: ``("-m", "--model")``; empty for a positional argument.
        value: placeholder of its value in help; empty if it has none.
        choices: the allowed values; empty for any.
        several: accepts any number of values.
        text: its help.
        group: title of its group; empty for the default groups.
    """

    flags: tuple[str, ...]
    value: str
    choices: tuple[str, ...]
    several: bool
    text: str
    group: str = ""


@dataclass(frozen=True)
class Command:
    """The program, a verb, or a subcommand of a verb.

    Attributes:
        words: the verb and the subcommand, if any; empty for the program.
        summary: one line.
        text: the whole description.
        usage: on one line, starting with the program's name.
        arguments: in the order of the help.
        examples: command lines without the program's name.
        subcommands: names of verbs or subcommands.
    """

    words: tuple[str, ...]
    summary: str
    text: str
    usage: str
    arguments: tuple[Argument, ...]
    examples: tuple[str, ...]
    subcommands: tuple[str, ...]

    @property
    def positional(self) -> tuple[Argument, ...]:
        """The arguments without a flag."""
        return tuple(argument for argument in self.arguments if not argument.flags)

    @property
    def options(self) -> tuple[Argument, ...]:
        """The arguments with a flag."""
        return tuple(argument for argument in self.arguments if argument.flags)


def all_commands() -> list[Command]:
    """The program, then every verb followed by its subcommands. Imports all verbs."""
    parser = parser_of(verbs())
    return list(_commands(parser, (), parser.description or ""))


def _commands(parser: argparse.ArgumentParser, words: tuple[str, ...], summary: str) -> Iterator[Command]:
    nested = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    children = {name: child for action in nested for name, child in action.choices.items()}
    titles = {action.dest: action.help or "" for action in nested for action in action._choices_actions}
    lines = (parser.epilog or "").splitlines()
    yield Command(
        words,
        summary,
        parser.description or "",
        " ".join(parser.format_usage().removeprefix("usage: ").split()),
        tuple(_arguments(parser)),
        tuple(line.strip().removeprefix(f"{parser.prog.split()[0]} ").replace("%%", "%") for line in lines[1:]),
        tuple(children),
    )
    for name, child in children.items():
        yield from _commands(child, (*words, name), titles[name].replace("%%", "%"))


def _arguments(parser: argparse.ArgumentParser) -> Iterator[Argument]:
    ordinary = (parser._positionals, parser._optionals)
    for group in parser._action_groups:
        for action in group._group_actions:
            if not isinstance(action, argparse._SubParsersAction):
                yield _argument(parser, action, "" if group in ordinary else group.title or "")


def _argument(parser: argparse.ArgumentParser, action: argparse.Action, group: str) -> Argument:
    choices = tuple(map(str, action.choices or ()))
    value = "" if action.nargs == 0 else _value(action, choices)
    text = parser._get_formatter()._expand_help(action) if action.help else ""
    return Argument(tuple(action.option_strings), value, choices, action.nargs in ("+", "*"), text, group)


def _value(action: argparse.Action, choices: Sequence[str]) -> str:
    if action.metavar:
        return action.metavar if isinstance(action.metavar, str) else " ".join(action.metavar)
    return f"{{{','.join(choices)}}}" if choices else action.dest.upper()
