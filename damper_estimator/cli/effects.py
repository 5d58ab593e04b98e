"""List the physical effects that models consist of, or describe one.

Without NAME prints a table; with NAME the equation, parameters with units and bounds, settings, appearance in
measurements, and source.
"""

import argparse

from damper_estimator.cli.verb_support import add_json, write_results
from damper_estimator.effects.contract import KINDS, Effect
from damper_estimator.effects.discovery import all_effects, find_effect

EXAMPLES = (
    "effects",
    "effects oil_spring",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    parser.add_argument("name", metavar="NAME", nargs="?", help="an effect's name")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Prints one effect or all of them."""
    chosen = [find_effect(arguments.name)] if arguments.name else list(all_effects().values())
    if arguments.name:
        text, results = description(chosen[0]), as_json(chosen[0])
    else:
        text, results = table(chosen), {"effects": [as_json(effect) for effect in chosen]}
    write_results(arguments, text, results)
    return 0


def title(effect: Effect) -> str:
    """First line of an effect's description."""
    return effect.description.strip().partition("\n")[0]


def table(effects: list[Effect]) -> str:
    """All effects, one line each."""
    rows = [("effect", "kind", "phenomenon", ""), *((e.name, e.kind, e.phenomenon or "-", title(e)) for e in effects)]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    return "\n".join("  ".join([*(f"{row[i]:<{widths[i]}}" for i in range(3)), row[3]]).rstrip() for row in rows)


def description(effect: Effect) -> str:
    """Complete description of one effect."""
    lines = [effect.name, "", effect.description.strip(), "", f"kind: {effect.kind} ({KINDS[effect.kind]})"]
    if effect.phenomenon:
        lines.append(f"phenomenon: {effect.phenomenon}")
    if effect.parameters:
        lines += ["parameters:", *(f"  {line}" for line in parameter_lines(effect))]
    if effect.settings:
        lines += ["settings (never identified):", *(f"  {line}" for line in setting_lines(effect))]
    if effect.shows:
        lines.append(f"shows as: {effect.shows}")
    if effect.separate:
        lines.append(f"to separate it from similar effects: {effect.separate}")
    return "\n".join(lines)


def parameter_lines(effect: Effect) -> list[str]:
    """One line per parameter: unit, default, bounds, meaning."""
    return [
        f"{p.name}: {p.meaning}; {_unit(p.unit)}default {p.default:g}, from {p.lower:g} to {p.upper:g}"
        f"{f'; one per entry of {p.size}' if p.size else ''}{'; linear' if p.linear else ''}"
        for p in effect.parameters
    ]


def setting_lines(effect: Effect) -> list[str]:
    """One line per setting: unit, default, meaning."""
    return [f"{s.name}: {s.meaning}; {_unit(s.unit)}default {_number(s.default)}" for s in effect.settings]


def _unit(unit: str) -> str:
    return "" if unit in ("", "1") else f"{unit}, "


def _number(value: float | tuple[float, ...]) -> str:
    return f"[{', '.join(f'{v:g}' for v in value)}]" if isinstance(value, tuple) else f"{value:g}"


def as_json(effect: Effect) -> dict[str, object]:
    """One effect for JSON."""
    return {
        "name": effect.name,
        "kind": effect.kind,
        "phenomenon": effect.phenomenon or None,
        "title": title(effect),
        "description": effect.description.strip(),
        "parameters": [
            {
                "name": p.name,
                "unit": p.unit,
                "default": p.default,
                "lower": p.lower,
                "upper": p.upper,
                "meaning": p.meaning,
                "linear": p.linear,
                "size": p.size,
            }
            for p in effect.parameters
        ],
        "settings": [
            {
                "name": s.name,
                "unit": s.unit,
                "default": s.default,
                "lower": s.lower,
                "upper": s.upper,
                "meaning": s.meaning,
            }
            for s in effect.settings
        ],
        "shows": effect.shows,
        "test_to_separate": effect.separate,
    }
