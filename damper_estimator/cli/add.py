"""Add an effect to a model.

The kind of the effect determines its position: sources before effects that act on the force, modifiers after them, a
compliance around the sources. Its parameters have default values, or those of --set; identify them with fit.
"""

import argparse
from pathlib import Path

from damper_estimator.cli.verb_support import add_models
from damper_estimator.effects.discovery import LISTS, find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import load_model, save_model
from damper_estimator.model.element import labels, new_element

EXAMPLES = (
    "add oil_spring -m viscous_curve -o more.yaml",
    "add coulomb -m linear_viscous -o more.yaml --set force=80",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    parser.add_argument("effect", metavar="EFFECT", help="an effect's name; damper-estimator effects lists them")
    add_models(parser)
    parser.add_argument(
        "-o", "--output", metavar="MODEL.yaml", type=Path, required=True, help="file for the extended model"
    )
    parser.add_argument(
        "--set",
        dest="values",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="a parameter of the effect; may be repeated",
    )


def run(arguments: argparse.Namespace) -> int:
    """Writes the model with the effect, and prints its elements."""
    effect = find_effect(arguments.effect)
    if effect.name in LISTS:
        raise InputError(f"{effect.name}: is not an effect; write it in the model file")
    if effect.kind == "channel":
        title = effect.description.strip().partition("\n")[0].rstrip(".")
        raise InputError(
            f"{effect.name}: {title} belongs to the measurement chain; correct it in the signal map, not in a model"
        )
    model = load_model(arguments.model)
    changed = model.with_effect(new_element(effect, model.effects, _values(arguments.values)))
    save_model(changed, arguments.output)
    print(
        f"{changed.name}: {' -> '.join(label for label, _ in labels(changed.effects))}; written to {arguments.output}"
    )
    return 0


def _values(pairs: list[str]) -> dict[str, object]:
    """Values by name from ``name=1.5`` or ``name=1,2,3``."""
    values: dict[str, object] = {}
    for pair in pairs:
        name, found, text = pair.partition("=")
        try:
            numbers = [float(part) for part in text.split(",")]
        except ValueError:
            found = ""
        if not found:
            raise InputError(f"--set {pair}: is not NAME=VALUE with a number, or numbers separated by commas")
        values[name.strip()] = numbers if "," in text else numbers[0]
    return values
