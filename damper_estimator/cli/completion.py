"""Print a script for bash or zsh that completes verbs, options, and the names of models, effects and files.

Save it in the shell's folder for such scripts, as in the examples, and open a new shell. For zsh the folder must be in
fpath: fpath=(~/.zfunc $fpath) before compinit in ~/.zshrc. Repeat this after an update.
"""

import argparse
from collections.abc import Callable

EXAMPLES = (
    "completion bash > ~/.local/share/bash-completion/completions/damper-estimator",
    "completion zsh > ~/.zfunc/_damper-estimator",
)
SHELLS = ("bash", "zsh")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    parser.add_argument("shell", choices=SHELLS, help="name of the shell")


def run(arguments: argparse.Namespace) -> int:
    """Prints the script."""
    from damper_estimator.cli.completion_scripts import bash_script, zsh_script
    from damper_estimator.cli.parser_description import all_commands
    from damper_estimator.effects.discovery import all_effects
    from damper_estimator.model import library_models
    from damper_estimator.vehicle.full_car import library_vehicles

    write: Callable = {"bash": bash_script, "zsh": zsh_script}[arguments.shell]
    names = {"MODEL": tuple(library_models()), "EFFECT": tuple(all_effects()), "CAR": tuple(library_vehicles())}
    print(write(all_commands(), names), end="")
    return 0
