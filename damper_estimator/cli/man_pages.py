"""Manual pages (man, section 1) of the program and of each verb, made of the parsers of the command line."""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

from damper_estimator import __version__
from damper_estimator.cli.commands import Argument, Command
from damper_estimator.cli.main import PROGRAM

_STATUS = (
    ("0", "done"),
    ("1", "the input cannot be used; one line on standard error says which file, what is wrong and what to do"),
    ("2", "wrong usage"),
    ("130", "interrupted"),
)


def man_pages(commands: Sequence[Command]) -> dict[str, str]:
    """Pages (roff) by file name, such as ``damper-estimator-fit.1``; the program's own lists the verbs."""
    return {f"{_title(own)}.1": _page(own, commands) for own in commands}


def _title(command: Command) -> str:
    return "-".join((PROGRAM, *command.words))


def _page(command: Command, commands: Sequence[Command]) -> str:
    below = [own for own in commands if len(own.words) == len(command.words) + 1 and _is_below(own, command)]
    lines = [
        f'.TH {_title(command).upper()} 1 "" "{PROGRAM} {__version__}" "User Commands"',
        ".ad l",
        ".nh",
        *_section("NAME", f"{_text(_title(command))} \\- {_text(_as_name(command.summary))}"),
        *_section("SYNOPSIS", _text(command.usage)),
        *_section("DESCRIPTION", *_paragraphs(command.text)),
    ]
    if below:
        lines += [".SH COMMANDS", *(line for own in below for line in _item(own.words[-1], own.summary))]
    for title, own in groupby(
        command.arguments, key=lambda own: own.group or ("OPTIONS" if own.flags else "ARGUMENTS")
    ):
        lines += [f'.SH "{_text(title.upper())}"', *(line for one in own for line in _argument(one))]
    if command.examples:
        lines += [".SH EXAMPLES", ".nf", *(_text(f"{PROGRAM} {example}") for example in command.examples), ".fi"]
    lines += [".SH EXIT STATUS", *(line for status, text in _STATUS for line in _item(status, text))]
    others = [own for own in (*commands[:1], *below) if own != command]
    if others:
        lines += _section("SEE ALSO", ", ".join(f"\\fB{_text(_title(own))}\\fR(1)" for own in others))
    return "\n".join(lines) + "\n"


def _is_below(own: Command, command: Command) -> bool:
    return own.words[: len(command.words)] == command.words


def _section(title: str, *lines: str) -> list[str]:
    return [f".SH {title}", *lines]


def _paragraphs(text: str) -> Iterator[str]:
    for number, paragraph in enumerate(text.strip().split("\n\n")):
        if number:
            yield ".PP"
        yield _text(" ".join(paragraph.split()))


def _argument(own: Argument) -> Iterator[str]:
    name = ", ".join(own.flags) or own.value
    value = own.value if own.flags and own.value else ""
    yield from (".TP", f"\\fB{_text(name)}\\fR" + (f" \\fI{_text(value)}\\fR" if value else ""), _text(own.text))


def _item(name: str, text: str) -> Iterator[str]:
    yield from (".TP", f"\\fB{_text(name)}\\fR", _text(text))


def _as_name(summary: str) -> str:
    """A summary as whatis shows it: no full stop, no capital but in names."""
    short = summary.strip().rstrip(".")
    return short if short[:2].isupper() else short[:1].lower() + short[1:]


def _text(text: str) -> str:
    """Text without meaning to roff: hyphens as typed, lists broken at commas, no line that begins as a request."""
    plain = text.replace("\\", "\\e").replace("-", "\\-").replace("``", '"')
    plain = re.sub(r",(?=\S)", r",\\:", plain)
    return f"\\&{plain}" if plain.startswith((".", "'")) else plain
