"""The texts around the translated functions: comments, structs, numbers of the model, interface functions."""

import textwrap
from collections.abc import Callable
from datetime import date
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.codegen.c_function import comment
from damper_estimator.codegen.values import kind_of, literal
from damper_estimator.model import DamperModel
from damper_estimator.model.element import labels

if TYPE_CHECKING:
    from damper_estimator.codegen.c_source import Damper

PRELUDE = """/*
 * Python's int(): the whole part of a number; the lowest integer where it has none (NaN, or too large), as a
 * processor's conversion gives it, where C leaves it undefined.
 */
static int64_t whole_part(REAL number)
{
    if ((number > -9.2e18SUFFIX) && (number < 9.2e18SUFFIX)) {
        return (int64_t)number;
    }
    return INT64_MIN;
}"""

STATUS = ("GOOD", "WARMING_UP", "EXTRAPOLATING", "DEGRADED", "STALE")
VERDICTS = ("ACCEPTED", "START", "GAP", "STEP_BACK", "DUPLICATE", "INVERSION", "NON_FINITE")

# Meaning of the members of the structs that a program fills in or reads.
MEMBERS = {
    "input": {
        "stamp": "ns, of the displacement, any origin",
        "displacement": "m, positive in extension",
        "command": "A (or V, or 1), where command_arrived is set",
        "temperature": "deg C, where temperature_arrived is set",
        "pressure": "Pa, where pressure_arrived is set",
        "acceleration": "m/s^2, relative, of the fusion, where acceleration_arrived is set",
        "acceleration_stamp": "ns",
        "command_arrived": "1: came since the last step; 0: the last value holds",
        "temperature_arrived": "the same",
        "pressure_arrived": "the same",
        "acceleration_arrived": "the same",
        "suspect": "1: the sender of this sample is doubtful",
        "reach": "1: compute force_min to dforce_dcurrent (four to five more evaluations of the model)",
    },
    "output": {
        "displacement": "m, filtered",
        "velocity": "m/s",
        "acceleration": "m/s^2",
        "force": "N, positive where it resists extension; the last finite one if the model has none",
        "force_stddev": "N, three of it cover the errors of the fit; NaN for a model without fit",
        "force_min": "N, lowest force that a command can reach; NaN if not requested or without a command",
        "force_max": "N, highest",
        "dforce_dvelocity": "N s/m",
        "dforce_dcurrent": "N/A",
        "status": "GOOD to DEGRADED, see the enumeration",
        "trusted": "the same regardless of the command's present value: may a controller act?",
        "verdict": "treatment of the sample; from DUPLICATE on it was dropped and all other members are unchanged",
    },
    "answer": {
        "current": "A, command for the desired force; NaN without a desired force",
        "expected": "N, the force that the command will reach",
        "force_min": "N, lowest force that can be reached",
        "force_max": "N",
        "dforce_dcurrent": "N/A, at the answer",
        "evaluations": "of the model",
        "reached": "1 if expected is the desired force",
    },
    "state": {},
}  # fmt: skip


def comment_line(text: str) -> str:
    """Text as a comment on one line."""
    return comment(text).replace("/*\n *", "/*").replace("\n */", " */")


def heading(model: DamperModel, damper: "Damper", today: date, version: str) -> str:
    """The heading of both files."""
    deployed = damper.deployed
    fit = (
        f"residual {deployed.stddev:.4g} N" if deployed.is_identified else "none: the status never rises above DEGRADED"
    )
    lines = [
        f"Damper {damper.name}: model {model.name}",
        *textwrap.wrap(f"Source: {model.source}", 110, subsequent_indent="    "),
        f"Written on {today.isoformat()} by damper_estimator {version}; do not edit, export again.",
        f"SHA-256 of the model's file: {damper.checksum or 'unknown (the model was not read from a file)'}",
        f"Filter: {f'third-order Butterworth, {deployed.cutoff:g} Hz' if deployed.cutoff > 0.0 else 'none'}.",
        f"Gaps beyond {deployed.max_gap:g} s reset the state; the motion is predicted {deployed.lead:g} s ahead.",
        f"Fit: {fit}.",
    ]
    if damper.limits is not None:
        lines.append(f"Inverse: command from {damper.limits[0]:g} to {damper.limits[1]:g}.")
    lines += [
        "",
        "SI units. C99, no allocation, no global state; needs math.h, stdint.h and stdbool.h. For results that agree",
        "bit for bit with damper-estimator's, compile with -ffp-contract=off and without -ffast-math.",
    ]
    return comment("\n".join(lines))


def struct(prefix: str, suffix: str, dtype: np.dtype, c_type: Callable[[str], str]) -> str:
    """A struct of a record's type."""
    meanings = MEMBERS[suffix]
    lines = ["typedef struct {"]
    if suffix == "state":
        real = c_type("real")
        lines += [
            f"    const {real} *parameters; /* of the model, in order of {prefix}_parameters */",
            f"    const {real} *settings;",
        ]
    for name in dtype.names:
        field = dtype[name]
        size = int(np.prod(field.shape)) if field.shape else 0
        length = f"[{max(size, 1)}]" if field.shape else ""
        meaning = f" /* {meanings[name]} */" if name in meanings else ""
        lines.append(f"    {c_type(kind_of(field.base))} {name}{length};{meaning}")
    return "\n".join([*lines, f"}} {prefix}_{suffix};"])


def header(damper: "Damper", head: str, structs: str) -> str:
    """The header."""
    name, guard = damper.name, f"{damper.name.upper()}_H"
    real = "float" if damper.single else "double"
    enums = [
        "enum { " + ", ".join(f"{name.upper()}_{word} = {i}" for i, word in enumerate(words)) + " };"
        for words in (STATUS, VERDICTS)
    ]
    declared = [
        comment("Call before the first use: sets the model's parameters and the initial state."),
        f"void {name}_init({name}_state *state);",
        comment("Sets the initial state; parameters are unchanged."),
        f"void {name}_reset({name}_state *state);",
        comment(STEP),
        f"int32_t {name}_step({name}_state *state, const {name}_input *input, {name}_output *output);",
        comment(STATUS_AT),
        f"uint8_t {name}_status_at(const {name}_state *state, int64_t now);",
    ]
    if damper.limits is not None:
        declared += [
            comment(INVERSE),
            f"void {name}_inverse({name}_state *state, {real} desired, {name}_answer *answer);",
        ]
    wrapped = "\n".join(textwrap.fill(enum, 110, subsequent_indent="    ") for enum in enums)
    sizes = f"extern const {real} {name}_parameters[{max(len(damper.deployed.model.slots), 1)}];"
    return "\n\n".join(
        [head, f"#ifndef {guard}\n#define {guard}", "#include <stdbool.h>\n#include <stdint.h>",
         '#ifdef __cplusplus\nextern "C" {\n#endif',
         f"{comment('Status of an estimate, then verdicts on samples.')}\n{wrapped}", structs, sizes,
         "\n".join(declared), "#ifdef __cplusplus\n}\n#endif", "#endif\n"]
    )  # fmt: skip


STEP = """Processes one sample. Returns its verdict; below DUPLICATE the output was written, otherwise the sample was
dropped. A stamp older than the last one by more than the longest gap, a gap and the first sample reset the state."""
STATUS_AT = """Status of the last estimate at a time in ns of the stamps' clock: STALE if its sample is too old."""
INVERSE = """The command for a desired force in N (NaN: none) after the last sample; can be called several times."""


def numbers(damper: "Damper", suffix: str) -> str:
    """Parameters and settings of the model as constant arrays, each parameter with its address, unit and meaning."""
    model, real = damper.deployed.model, "float" if damper.single else "double"
    slots = [(slot.value, f"{slot.address}, {slot.parameter.unit}: {slot.parameter.meaning}") for slot in model.slots]
    settings = []
    for label, element in labels(model.effects):
        if element.effect.kind != "path":
            given = element.effect.prepare(element.parameters, element.settings)
            settings += [(float(number), f"{label}[{i}]") for i, number in enumerate(given)]
    named = (f"const {real} {damper.name}_parameters", slots), (f"static const {real} SETTINGS", settings)
    return "\n\n".join(_array(head, items, suffix) for head, items in named)


def _array(head: str, items: list[tuple[float, str]], suffix: str) -> str:
    codes = [(literal(value, suffix).code, meaning) for value, meaning in items or [(0.0, "none")]]
    width = max(len(code) for code, _ in codes) + 1
    lines = [f"    {code + ',':{width}} {comment_line(meaning)}" for code, meaning in codes]
    return "\n".join([f"{head}[{len(codes)}] = {{", *lines, "};"])


def visible(damper: "Damper", verb: str, call: str) -> str:
    """One function of the interface, which calls its translation."""
    name, real = damper.name, "float" if damper.single else "double"
    head, way = {
        "step": (f"int32_t {name}_step({name}_state *state, const {name}_input *input, {name}_output *output)",
                 f"return (int32_t){call};"),
        "status_at": (f"uint8_t {name}_status_at(const {name}_state *state, int64_t now)", f"return (uint8_t){call};"),
        "inverse": (f"void {name}_inverse({name}_state *state, {real} desired, {name}_answer *answer)", f"{call};"),
    }[verb]  # fmt: skip
    return f"{head}\n{{\n    {way}\n}}"


def beginnings(damper: "Damper", assignments: list[str]) -> list[str]:
    """``init`` and ``reset``."""
    name = damper.name
    lines = "\n".join(f"    {line}" for line in assignments)
    begin = f"state->parameters = {name}_parameters;\n    state->settings = SETTINGS;\n    {name}_reset(state);"
    return [
        f"void {name}_reset({name}_state *state)\n{{\n{lines}\n}}",
        f"void {name}_init({name}_state *state)\n{{\n    {begin}\n}}",
    ]
