"""One page per effect, from its declaration: meaning, equation, source, parameters, picture, look-alikes, bench."""

import re
from collections.abc import Iterator
from functools import cache

from equations import block_html, paragraph_html, with_symbols
from signatures import signature, svgs

from damper_estimator.diagnosis import TESTS
from damper_estimator.effects.contract import KINDS, Effect
from damper_estimator.effects.discovery import all_effects
from damper_estimator.model import library_models, load_model
from damper_estimator.model.element import walk

ATLAS = {test.name: test for test in TESTS}
THEMES = ("light", "dark")


def files() -> Iterator[tuple[str, str]]:
    """Path in the site and content of every generated file: the index, the pages and their pictures."""
    yield "effects/index.md", index()
    for effect in all_effects().values():
        drawn = signature(effect)
        for name, picture in svgs(drawn).items():
            yield f"effects/{effect.name}_{name}.svg", picture
        yield f"effects/{effect.name}.md", page(effect, drawn.values)


def title(effect: Effect) -> str:
    """First line of an effect's description, without the full stop."""
    return effect.description.strip().partition("\n")[0].rstrip(".")


def index() -> str:
    """All effects by the phenomenon that they stand for."""
    groups: dict[str, list[Effect]] = {}
    for effect in all_effects().values():
        groups.setdefault(effect.phenomenon, []).append(effect)
    text = [
        "# Effects",
        "An effect is one physical phenomenon in one file; a model is a list of effects. Those that stand for a "
        "phenomenon are what [a diagnosis](../diagnosis.md) can name; several may stand for one. "
        "`damper-estimator effects NAME` prints the same.",
    ]
    for phenomenon in sorted(groups, key=lambda name: (not name, name)):
        text += [
            f"## {spoken(phenomenon) if phenomenon else 'Baselines and parts of models'}",
            "| effect | |\n| --- | --- |",
        ]
        text[-1] += "".join(f"\n| [{e.name}]({e.name}.md) | {title(e)} |" for e in groups[phenomenon])
    return "\n\n".join(text)


def spoken(phenomenon: str) -> str:
    """A phenomenon as a heading."""
    return phenomenon.replace("_", " ").capitalize()


def page(effect: Effect, values) -> str:
    """The page of one effect."""
    parts = [f"# {effect.name}", f"**{title(effect)}.**", facts(effect), *description(effect)]
    parts += ["## Parameters", parameters(effect)] if effect.parameters else []
    parts += (
        ["## Settings", "Fixed by the model file, never identified.\n\n" + settings(effect)] if effect.settings else []
    )
    parts += ["## How it shows", *shown(effect, values), "## What looks like it", *look_alikes(effect)]
    parts += ["## How often it is found", measured(effect), "## Use it", use(effect)]
    return "\n\n".join(parts)


def facts(effect: Effect) -> str:
    """Kind, phenomenon and memory in a line each."""
    lines = [f"- kind: {effect.kind}, which {KINDS[effect.kind]}"]
    lines += [f"- phenomenon: `{effect.phenomenon}`"] if effect.phenomenon else []
    if effect.states:
        order = f"; the error falls with the step to the power {effect.order}" if effect.order else ""
        numbers = "1 number" if effect.states == 1 else f"{effect.states} numbers"
        lines.append(f"- memory: {numbers} from sample to sample{order}")
    return "\n".join(lines)


def description(effect: Effect) -> Iterator[str]:
    """Equation, symbols and source, from the docstring."""
    _, _, body = effect.description.strip().partition("\n")
    text, _, source = body.partition("Source:")
    yield "## Equation"
    for block in re.split(r"\n\s*\n", text.strip("\n")):
        indented = all(line.startswith("    ") for line in block.splitlines() if line.strip())
        if block.strip():
            yield block_html(block) if indented else paragraph_html(" ".join(block.split()))
    if source:
        yield "## Source"
        yield paragraph_html(" ".join(source.split()))


def unit(text: str) -> str:
    """A unit as it is printed."""
    raised = str.maketrans("0123456789.p", "⁰¹²³⁴⁵⁶⁷⁸⁹·ᵖ")
    return "–" if text in ("", "1") else re.sub(r"\^([0-9.p]+)", lambda found: found[1].translate(raised), text)


def number(value: float | tuple[float, ...]) -> str:
    """A number or a list of numbers."""
    return ", ".join(f"{one:g}" for one in value) if isinstance(value, tuple) else f"{value:g}"


def parameters(effect: Effect) -> str:
    """The parameters with units and bounds."""
    rows = ["| name | unit | default | from | to | meaning |", "| --- | --- | ---: | ---: | ---: | --- |"]
    for p in effect.parameters:
        several = f"; one per entry of {' and '.join(f'`{axis}`' for axis in p.axes)}" if p.size else ""
        rows.append(
            f"| `{p.name}` | {unit(p.unit)} | {p.default:g} | {p.lower:g} | {p.upper:g} "
            f"| {with_symbols(p.meaning)}{several} |"
        )
    return "\n".join(rows)


def settings(effect: Effect) -> str:
    """The settings with units."""
    rows = ["| name | unit | default | meaning |", "| --- | --- | --- | --- |"]
    rows += [
        f"| `{s.name}` | {unit(s.unit)} | {number(s.default)} | {with_symbols(s.meaning)} |" for s in effect.settings
    ]
    return "\n".join(rows)


def shown(effect: Effect, values) -> Iterator[str]:
    """In words, and the picture."""
    yield (
        f"{effect.shows[:1].upper()}{effect.shows[1:]}." if effect.shows else "Its declaration says nothing about that."
    )
    pictures = {"force": f"Force over velocity, with {effect.name} and without it", "difference": "The difference"}
    yield "\n".join(
        f"![{words}]({effect.name}_{name}_{theme}.svg#only-{theme}){{ .half }}"
        for name, words in pictures.items()
        for theme in THEMES
    )
    given = ", ".join(f"`{name}` {float(f'{value:.3g}'):g}" for name, value in values.items())
    yield (
        "A linear damper of 1500 N s/m, with the effect and without it: the force over velocity, and what a model "
        f"lacks that does not have the effect. {'Drawn with ' + given + '.' if given else ''}"
    ).strip()


def look_alikes(effect: Effect) -> Iterator[str]:
    """What tells it apart, and the effects that the same form-free tests speak for."""
    yield (
        f"To separate it: {effect.separate}."
        if effect.separate
        else "Its declaration names no test that tells it apart."
    )
    if effect.tests:
        rows = "".join(f"\n| {name} | {ATLAS[name].shows} |" for name in effect.tests)
        head = "| test | the error depends on |\n| --- | --- |"
        yield f"[Form-free tests](../diagnosis.md) in which it shows:\n\n{head}{rows}"
    same = [e for e in all_effects().values() if e.phenomenon == effect.phenomenon != "" and e.name != effect.name]
    other = [e for e in all_effects().values() if e.phenomenon != effect.phenomenon and related(effect, e)]
    if other:
        yield f"Other phenomena that show in these tests, or in tests that can imitate them: {links(other, True)}."
    if same:
        yield f"Other forms of the same phenomenon: {links(same)}."


def related(effect: Effect, other: Effect) -> bool:
    """Whether tests of the two are the same, or one can imitate the other's."""
    pairs = [(ATLAS[a], ATLAS[b]) for a in effect.tests for b in other.tests]
    return any(a == b or a.name in b.contains or b.name in a.contains for a, b in pairs)


def links(effects: list[Effect], phenomena: bool = False) -> str:
    """The effects as links, with their phenomena if wanted."""
    return ", ".join(
        f"[{e.name}]({e.name}.md)" + (f" ({e.phenomenon.replace('_', ' ')})" if phenomena else "") for e in effects
    )


def measured(effect: Effect) -> str:
    """What the bench of random dampers measured for the phenomenon; that it has not, where it has not."""
    if not effect.phenomenon:
        return "It stands for no phenomenon, so a diagnosis does not name it."
    row = bench_rows().get(effect.phenomenon)
    if row is None:
        return (
            f"No measurement is stored for `{effect.phenomenon}`. `make bench-diagnosis` hides it in dampers drawn at "
            "random and counts; [how far to trust a finding](../diagnosis_bench.md) says how."
        )
    cells = "\n".join(f"| {name} | {value} |" for name, value in row.items())
    return f"For `{effect.phenomenon}`, from [the bench](../diagnosis_bench.md):\n\n| | |\n| --- | --- |\n{cells}"


def bench_rows() -> dict[str, dict[str, str]]:
    """By phenomenon, the row of the bench's table."""
    from reference_pages import ROOT

    text = (ROOT / "docs" / "diagnosis_bench.md").read_text(encoding="utf-8")
    section = text.partition("phenomenon by phenomenon")[2].partition("\n#")[0]
    rows = [
        [cell.strip() for cell in line.strip("| ").split("|")] for line in section.splitlines() if line.startswith("|")
    ]
    if len(rows) < 3:
        return {}
    return {row[0]: dict(zip(rows[0][1:], row[1:], strict=False)) for row in rows[2:]}


def use(effect: Effect) -> str:
    """How it is put into a model, and which models have it."""
    if effect.kind == "channel":
        text = (
            "It is a fault of the measurement chain and belongs in the signal map, not in a model: "
            "`improve --signals-out map.yaml` writes it there."
        )
    else:
        text = f"    damper-estimator add {effect.name} -m mine.yaml -o more.yaml"
    having = [name for name, effects in models_with_effects().items() if effect.name in effects]
    return text + (
        f"\n\nIn the models {', '.join(f'[{name}](../models.md#{name})' for name in having)}." if having else ""
    )


@cache
def models_with_effects() -> dict[str, set[str]]:
    """The names of the effects of every model of the library."""
    return {name: {e.effect.name for e in walk(load_model(path).effects)} for name, path in library_models().items()}
