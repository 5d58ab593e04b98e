"""Scripts by which shells complete the command line, made of its description."""

import shlex
from collections.abc import Iterator, Mapping, Sequence

from damper_estimator.cli.commands import Argument, Command
from damper_estimator.cli.main import PROGRAM

Names = Mapping[str, Sequence[str]]
"""Known names by what stands for them in help, such as MODEL."""

# What stands for a file or folder in help, as a part of the word.
_FILES = ("BAG", "FILE", "DIR", "FOLDER", "YAML", "CSV", "MODEL", "CAR", "MANIFEST", "MAP")

_BASH = """\
# bash completion for {program}; made by `{program} completion bash`
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
# zsh completion for {program}; made by `{program} completion zsh`
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
        names="\n".join(f'    local {_variable(key)}="{" ".join(own)}"' for key, own in names.items()),
        nested="|".join(_nested(commands)),
        commands="\n".join(_bash_command(own, names) for own in commands),
        values="\n".join(line for own in commands for line in _bash_values(own, names)),
    )


def _nested(commands: Sequence[Command]) -> list[str]:
    """Verbs that have commands below them; a name that nobody types where there are none."""
    return [" ".join(own.words) for own in commands if own.words and own.below] or ["-"]


def _bash_command(command: Command, names: Names) -> str:
    options = " ".join(flag for own in command.options for flag in own.flags)
    words = [*command.below, *(word for own in command.positional for word in _known(command, own, names))]
    files = "yes" if any(_is_file(own) for own in command.positional) else ""
    return f'        "{" ".join(command.words)}") options="{options}" words="{" ".join(words)}" files="{files}" ;;'


def _bash_values(command: Command, names: Names) -> Iterator[str]:
    for own in command.options:
        if own.value:
            patterns = "|".join(f'"{" ".join(command.words)}:{flag}"' for flag in own.flags)
            files = "yes" if _is_file(own) else ""
            yield f'        {patterns}) words="{" ".join(_known(command, own, names))}" files="{files}" ;;'


def zsh_script(commands: Sequence[Command], names: Names) -> str:
    """The script for zsh, a file of the name ``_damper-estimator`` in ``fpath``."""
    summaries = {own.words: own.summary for own in commands}
    return _ZSH.format(
        program=PROGRAM,
        names="\n".join(f"    local -a {_variable(key)}=({' '.join(own)})" for key, own in names.items()),
        nested="|".join(_nested(commands)),
        commands="\n".join(_zsh_command(own, names, summaries) for own in commands),
    )


def _zsh_command(command: Command, names: Names, summaries: Mapping[tuple[str, ...], str]) -> str:
    start = f'        "{" ".join(command.words)}")\n'
    # What belongs to the words before is taken away, so that _arguments sees this command's own.
    shift = "            shift $((base - 1)) words; (( CURRENT -= base - 1 ))\n" if command.words else ""
    described = [f"{name}:{summaries[(*command.words, name)]}".replace("\\", "") for name in command.below]
    below = f"            below=({' '.join(map(shlex.quote, described))})\n" if described else ""
    specifications = [text for own in command.options for text in _zsh_option(command, own, names)]
    specifications += [_zsh_position(command, own, names) for own in command.positional]
    if command.below:
        specifications.append("1:command:{ _describe command below }")
    lines = " \\\n".join(f"                {shlex.quote(text)}" for text in specifications)
    return f"{start}{below}{shift}            _arguments -S \\\n{lines}\n            ;;"


def _zsh_option(command: Command, own: Argument, names: Names) -> Iterator[str]:
    value = f":{_zsh_text(own.value)}:{_zsh_action(command, own, names)}" if own.value else ""
    for flag in own.flags:
        yield f"*{flag}[{_zsh_text(own.text)}]{value}"


def _zsh_position(command: Command, own: Argument, names: Names) -> str:
    return f"{'*' if own.several else ''}:{_zsh_text(own.value)}:{_zsh_action(command, own, names)}"


def _zsh_action(command: Command, own: Argument, names: Names) -> str:
    known = " ".join(_known(command, own, names))
    if _is_file(own):
        return f"{{ compadd -- {known}; _files }}" if known else "_files"
    return f"{{ compadd -- {known} }}" if known else " "


def _zsh_text(text: str) -> str:
    for letter in "\\[]:":
        text = text.replace(letter, f"\\{letter}")
    return " ".join(text.split())


def _known(command: Command, own: Argument, names: Names) -> Sequence[str]:
    """The values that can be listed: choices, or the variable with the names of what is installed."""
    # `effects NAME` and `models NAME`.
    key = command.words[-1].upper().removesuffix("S") if own.value == "NAME" and not own.flags else own.value
    return own.choices or ((f"${_variable(key)}",) if key in names else ())


def _variable(key: str) -> str:
    return f"all_{key.lower()}s"


def _is_file(own: Argument) -> bool:
    return not own.choices and any(part in own.value.upper() for part in _FILES)
