"""Scripts for completion in shells, generated from the description of the command line."""

import shlex
from collections.abc import Iterator, Mapping, Sequence

from damper_estimator.cli.main import PROGRAM
from damper_estimator.cli.parser_description import Argument, Command

Names = Mapping[str, Sequence[str]]
"""Known names by their placeholder in help, such as MODEL."""

# Parts of the placeholders of files and folders in help.
_FILES = ("BAG", "FILE", "DIR", "FOLDER", "YAML", "CSV", "MODEL", "CAR", "MANIFEST", "MAP")

_BASH = """\
# bash completion for {program}; written by `{program} completion bash`
_damper_estimator() {{
    local current="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}"
    local command="" options="" words="" files=""
{names}
    (( COMP_CWORD > 1 )) && command="${{COMP_WORDS[1]}}"
    case "$command" in
        {nested}) (( COMP_CWORD > 2 )) && command+=" ${{COMP_WORDS[2]}}" ;;
    esac
    case "$command" in
{commands}
    esac
    case "$command:$before" in
{values}
        *) [[ $current == -* ]] && words="$options" files="" ;;
    esac
    COMPREPLY=($(compgen -W "$words" -- "$current"))
    if [[ -n $files ]]; then
        compopt -o filenames 2>/dev/null
        mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -f -- "$current")
    fi
}}
complete -F _damper_estimator {program}
"""

_ZSH = """\
#compdef {program}
# zsh completion for {program}; written by `{program} completion zsh`
_damper_estimator() {{
    local command="" base=1
    local -a below
{names}
    (( CURRENT > 2 )) && command="$words[2]" && base=2
    case "$command" in
        {nested}) (( CURRENT > 3 )) && command+=" $words[3]" && base=3 ;;
    esac
    case "$command" in
{commands}
    esac
}}
_damper_estimator "$@"
"""


def bash_script(commands: Sequence[Command], names: Names) -> str:
    """The script for bash, to be sourced."""
    return _BASH.format(
        program=PROGRAM,
        names="\n".join(f'    local {_variable(key)}="{" ".join(values)}"' for key, values in names.items()),
        nested="|".join(_nested(commands)),
        commands="\n".join(_bash_command(command, names) for command in commands),
        values="\n".join(line for command in commands for line in _bash_values(command, names)),
    )


def _nested(commands: Sequence[Command]) -> list[str]:
    """Verbs with subcommands; a name that nobody types if there are none."""
    return [" ".join(command.words) for command in commands if command.words and command.subcommands] or ["-"]


def _bash_command(command: Command, names: Names) -> str:
    options = " ".join(flag for argument in command.options for flag in argument.flags)
    words = [
        *command.subcommands,
        *(word for argument in command.positional for word in _known(command, argument, names)),
    ]
    files = "yes" if any(_is_file(argument) for argument in command.positional) else ""
    return f'        "{" ".join(command.words)}") options="{options}" words="{" ".join(words)}" files="{files}" ;;'


def _bash_values(command: Command, names: Names) -> Iterator[str]:
    for argument in command.options:
        if argument.value:
            patterns = "|".join(f'"{" ".join(command.words)}:{flag}"' for flag in argument.flags)
            files = "yes" if _is_file(argument) else ""
            yield f'        {patterns}) words="{" ".join(_known(command, argument, names))}" files="{files}" ;;'


def zsh_script(commands: Sequence[Command], names: Names) -> str:
    """The script for zsh, a file of the name ``_damper-estimator`` in ``fpath``."""
    summaries = {command.words: command.summary for command in commands}
    return _ZSH.format(
        program=PROGRAM,
        names="\n".join(f"    local -a {_variable(key)}=({' '.join(values)})" for key, values in names.items()),
        nested="|".join(_nested(commands)),
        commands="\n".join(_zsh_command(command, names, summaries) for command in commands),
    )


def _zsh_command(command: Command, names: Names, summaries: Mapping[tuple[str, ...], str]) -> str:
    start = f'        "{" ".join(command.words)}")\n'
    # The words of the command are removed, so that _arguments sees only its arguments.
    shift = "            shift $((base - 1)) words; (( CURRENT -= base - 1 ))\n" if command.words else ""
    described = [f"{name}:{summaries[(*command.words, name)]}".replace("\\", "") for name in command.subcommands]
    below = f"            below=({' '.join(map(shlex.quote, described))})\n" if described else ""
    specifications = [text for argument in command.options for text in _zsh_option(command, argument, names)]
    specifications += [_zsh_position(command, argument, names) for argument in command.positional]
    if command.subcommands:
        specifications.append("1:command:{ _describe command below }")
    lines = " \\\n".join(f"                {shlex.quote(text)}" for text in specifications)
    return f"{start}{below}{shift}            _arguments -S \\\n{lines}\n            ;;"


def _zsh_option(command: Command, argument: Argument, names: Names) -> Iterator[str]:
    value = f":{_zsh_text(argument.value)}:{_zsh_action(command, argument, names)}" if argument.value else ""
    for flag in argument.flags:
        yield f"*{flag}[{_zsh_text(argument.text)}]{value}"


def _zsh_position(command: Command, argument: Argument, names: Names) -> str:
    return f"{'*' if argument.several else ''}:{_zsh_text(argument.value)}:{_zsh_action(command, argument, names)}"


def _zsh_action(command: Command, argument: Argument, names: Names) -> str:
    known = " ".join(_known(command, argument, names))
    if _is_file(argument):
        return f"{{ compadd -- {known}; _files }}" if known else "_files"
    return f"{{ compadd -- {known} }}" if known else " "


def _zsh_text(text: str) -> str:
    for letter in "\\[]:":
        text = text.replace(letter, f"\\{letter}")
    return " ".join(text.split())


def _known(command: Command, argument: Argument, names: Names) -> Sequence[str]:
    """The values to offer: choices, or the variable with the installed names."""
    # `effects NAME` and `models NAME`.
    key = (
        command.words[-1].upper().removesuffix("S")
        if argument.value == "NAME" and not argument.flags
        else argument.value
    )
    return argument.choices or ((f"${_variable(key)}",) if key in names else ())


def _variable(key: str) -> str:
    return f"all_{key.lower()}s"


def _is_file(argument: Argument) -> bool:
    return not argument.choices and any(part in argument.value.upper() for part in _FILES)
