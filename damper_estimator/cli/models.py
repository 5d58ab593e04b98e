"""List the installed models, or describe one.

Without NAME prints a table; with NAME (or a model file) source and notes, and for each effect the equation, values,
units, bounds and settings. A fitted model also shows its recordings and region of validity.
"""

import argparse

from damper_estimator.cli.verb_support import add_json, write_results
from damper_estimator.effects.contract import Effect
from damper_estimator.model import DamperModel, library_models, load_model
from damper_estimator.model.element import labels

EXAMPLES = (
    "models",
    "models spencer",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the arguments."""
    parser.add_argument("name", metavar="NAME", nargs="?", help="a model's name, or a model file")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Prints one model or all installed ones."""
    if arguments.name:
        model = load_model(arguments.name)
        text, content = description(model), as_json(model)
    else:
        models = [load_model(path) for path in library_models().values()]
        text, content = table(models), {"models": [as_json(model) for model in models]}
    write_results(arguments, text, content)
    return 0


def table(models: list[DamperModel]) -> str:
    """All models, one line each."""
    width = max(len(model.name) for model in models)
    lines = [f"{'model':<{width}}  parameters (identified)  source"]
    for model in models:
        free = sum(not slot.fixed for slot in model.slots)
        lines.append(f"{model.name:<{width}}  {f'{len(model.slots)} ({free})':<23}  {model.source}")
    return "\n".join(lines)


def description(model: DamperModel) -> str:
    """Complete description of one model."""
    lines = [model.name, "", f"source: {model.source}"]
    if model.notes:
        lines.append(f"notes: {model.notes.strip()}")
    lines += ["", "parameters:", *_parameter_lines(model), "", "effects, in order:"]
    for effect in _distinct(model):
        text = effect.description.strip().replace("\n", "\n    ").replace("\n    \n", "\n\n")
        lines += [f"  {effect.name} ({effect.kind})", f"    {text}", ""]
    lines += _setting_lines(model) + _fit_lines(model)
    return "\n".join(lines).rstrip()


def _parameter_lines(model: DamperModel) -> list[str]:
    width = max(len(slot.address) for slot in model.slots)
    return [
        f"  {slot.address:<{width}}  {slot.value:>10.6g} {slot.parameter.unit}"
        f"  (from {slot.parameter.lower:g} to {slot.parameter.upper:g})"
        f"{'  fixed' if slot.fixed else ''}  {slot.parameter.meaning}"
        for slot in model.slots
    ]


def _setting_lines(model: DamperModel) -> list[str]:
    lines = []
    for label, element in labels(model.effects):
        for setting in element.effect.settings:
            lines.append(
                f"  {label}.{setting.name} = {element.settings[setting.name]} {setting.unit}  {setting.meaning}"
            )
    return ["settings:", *lines] if lines else []


def _fit_lines(model: DamperModel) -> list[str]:
    return ["fitted:", *(f"  {key}: {value}" for key, value in model.fit.items())] if model.fit else []


def _distinct(model: DamperModel) -> list[Effect]:
    return list({element.effect.name: element.effect for _, element in labels(model.effects)}.values())


def as_json(model: DamperModel) -> dict[str, object]:
    """One model for JSON."""
    return {
        "name": model.name,
        "source": model.source,
        "notes": model.notes,
        "effects": [
            {
                "label": label,
                "effect": element.effect.name,
                "description": element.effect.description.strip(),
                "settings": element.settings,
            }
            for label, element in labels(model.effects)
        ],
        "parameters": [
            {
                "name": slot.address,
                "value": slot.value,
                "unit": slot.parameter.unit,
                "lower": slot.parameter.lower,
                "upper": slot.parameter.upper,
                "meaning": slot.parameter.meaning,
                "fixed": slot.fixed,
            }
            for slot in model.slots
        ],
        "fit": model.fit,
    }
