"""Manual pages (man, section 1) of the program and each verb, generated from the parsers."""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

from damper_estimator import __version__
from damper_estimator.cli.main import PROGRAM
from damper_estimator.cli.parser_description import Argument, Command

_STATUS = (
    ("0", "done"),
    ("1", "the input cannot be used; one line on standard error says which file, what is wrong and what to do"),
    ("2", "wrong usage"),
    ("130", "interrupted"),
)


def man_pages(commands: Sequence[Command]) -> dict[str, str]:
    """Pages (roff) by file name, such as ``damper-estimator-fit.1``; that of the program lists the verbs."""
    return {f"{_title(command)}.1": _page(command, commands) for command in commands}


def _title(command: Command) -> str:
    return "-".join((PROGRAM, *command.words))


def _page(command: Command, commands: Sequence[Command]) -> str:
    below = [child for child in commands if len(child.words) == len(command.words) + 1 and _is_below(child, command)]
    lines = [
        f'.TH {_title(command).upper()} 1 "" "{PROGRAM} {__version__}" "User Commands"',
        ".ad l",
        ".nh",
        *_section("NAME", f"{_text(_title(command))} \\- {_text(_as_name(command.summary))}"),
        *_section("SYNOPSIS", _text(command.usage)),
        *_section("DESCRIPTION", *_paragraphs(command.text)),
    ]
    if below:
        lines += [".SH COMMANDS", *(line for child in below for line in _item(child.words[-1], child.summary))]
    for title, group in groupby(
        command.arguments, key=lambda argument: argument.group or ("OPTIONS" if argument.flags else "ARGUMENTS")
    ):
        lines += [f'.SH "{_text(title.upper())}"', *(line for argument in group for line in _argument(argument))]
    if command.examples:
        lines += [".SH EXAMPLES", ".nf", *(_text(f"{PROGRAM} {example}") for example in command.examples), ".fi"]
    lines += [".SH EXIT STATUS", *(line for status, text in _STATUS for line in _item(status, text))]
    others = [other for other in (*commands[:1], *below) if other != command]
    if others:
        lines += _section("SEE ALSO", ", ".join(f"\\fB{_text(_title(other))}\\fR(1)" for other in others))
    return "\n".join(lines) + "\n"


def _is_below(child: Command, command: Command) -> bool:
    return child.words[: len(command.words)] == command.words


def _section(title: str, *lines: str) -> list[str]:
    return [f".SH {title}", *lines]


def _paragraphs(text: str) -> Iterator[str]:
    for number, paragraph in enumerate(text.strip().split("\n\n")):
        if number:
            yield ".PP"
        yield _text(" ".join(paragraph.split()))


def _argument(argument: Argument) -> Iterator[str]:
    name = ", ".join(argument.flags) or argument.value
    value = argument.value if argument.flags and argument.value else ""
    yield from (".TP", f"\\fB{_text(name)}\\fR" + (f" \\fI{_text(value)}\\fR" if value else ""), _text(argument.text))


def _item(name: str, text: str) -> Iterator[str]:
    yield from (".TP", f"\\fB{_text(name)}\\fR", _text(text))


def _as_name(summary: str) -> str:
    """A summary as whatis shows it: without full stop and initial capital."""
    short = summary.strip().rstrip(".")
    return short if short[:2].isupper() else short[:1].lower() + short[1:]


def _text(text: str) -> str:
    """Text escaped for roff: hyphens as typed, line breaks allowed after commas, no line that begins like a request."""
    plain = text.replace("\\", "\\e").replace("-", "\\-").replace("``", '"')
    plain = re.sub(r",(?=\S)", r",\\:", plain)
    return f"\\&{plain}" if plain.startswith((".", "'")) else plain
