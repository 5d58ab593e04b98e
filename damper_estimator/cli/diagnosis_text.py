"""The results of ``diagnose`` and ``improve`` as text."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill

from damper_estimator.cli.data_finding_text import print_findings
from damper_estimator.cli.verb_support import command
from damper_estimator.diagnosis import Diagnosis, Finding, Improvement
from damper_estimator.numbers import number
from damper_estimator.report.before_after import first_diagnosis
from damper_estimator.report.diagnosis_wording import (
    correction_rows,
    moved_rows,
    parameter_rows,
    step_name,
    stretches_sentence,
)

_WIDTH = 110


def print_diagnosis(damper: str, found: Diagnosis) -> None:
    """Prints one damper: verdict, faults of the recordings, findings with evidence, changed parameters."""
    print(f"{damper}: {found.sentence}")
    print_findings(found.data)
    print(*_findings(found), sep="\n", flush=True)


def _findings(found: Diagnosis) -> list[str]:
    share = f", {100.0 * found.rmse_n / found.force_rms_n:.2g} % of the force" if found.force_rms_n else ""
    lines = [
        f"  unseen error {number(found.rmse_n)} N{share}; noise floor {number(found.noise_floor_n)} N; "
        f"form-free reference {number(found.reference_n)} N"
    ]
    if found.stretches:
        lines.append(_wrapped(stretches_sentence(found), "  "))
    if found.findings:
        lines += _table(found.findings, "found" if found.verdict == "missing" else "as if by")
    for finding in found.findings:
        lines += _details(finding)
    if found.moved:
        rows = moved_rows(found)
        width = max(len(row["name"]) for row in rows)
        lines.append("  parameters that change when identified again:")
        lines += [
            _plain(
                f"    {row['name']:<{width}}  {row['before']} -> {row['after']} {row['error']} {row['unit']}"
            ).rstrip()
            for row in rows
        ]
    if not found.findings and not found.moved:
        best = next(
            (candidate for candidate in found.ranking if candidate.reason and (candidate.kept or candidate.refitted)),
            None,
        )
        if best is not None:
            lines.append(f"  best candidate: {best.phenomenon} ({best.effect}): {best.reason}")
    return lines


def _table(findings: Sequence[Finding], title: str) -> list[str]:
    """Gains and errors have different bases, which a line below the table names."""
    width = max(len(title), *(len(finding.phenomenon) for finding in findings))
    wide = max(len("effect"), *(len(finding.effect) for finding in findings))
    lines = [f"  {title:<{width}}  {'effect':<{wide}}  {'explains, 5 to 95 %':<21}  {'unseen error':<18}  confidence"]
    for finding in findings:
        gain = f"{100 * finding.gain:.0f} % ({100 * finding.low:z.0f} to {100 * finding.high:z.0f} %)"
        errors = f"{number(finding.rmse_before_n)} -> {number(finding.rmse_after_n)} N"
        lines.append(
            f"  {finding.phenomenon:<{width}}  {finding.effect:<{wide}}  {gain:<21}  {errors:<18}  "
            f"{100 * finding.confidence:.0f} %"
        )
    note = "explains: of the squared error without zero and drift; unseen error: with both, the effect in the model"
    return [*lines, f"  {note}"]


def _details(finding: Finding) -> list[str]:
    details = {
        "tied with": ", ".join(finding.tied_with),
        "evidence": finding.evidence,
        "test to separate": finding.test_to_separate,
        "remark": finding.remark,
        "values": ", ".join(_value(row) for row in parameter_rows(finding.parameters)),
    }
    lines = [f"  {finding.phenomenon}:"]
    return lines + [_wrapped(f"{name}: {text}", "    ") for name, text in details.items() if text]


def _value(row: Mapping[str, object]) -> str:
    error = "at its bound" if row["at_bound"] else row["error"]
    return _plain(" ".join(f"{part}" for part in (row["name"], row["value"], error, row["unit"]) if part))


def _plain(text: str) -> str:
    """The text without thin spaces between thousands, so that numbers can be copied."""
    return text.replace("\u2009", "")


def _wrapped(text: str, indent: str) -> str:
    return fill(text, _WIDTH, initial_indent=indent, subsequent_indent=f"{indent}  ", break_long_words=False)


def next_steps(
    found: Mapping[str, Diagnosis],
    bags: Sequence[Path],
    validate: Sequence[Path],
    model: str,
    reading: Sequence[str] = (),
) -> list[str]:
    """Commands that add the first finding, or improve the model automatically, for a shell.

    Args:
        reading: options by which the recordings were read.
    """
    effects = [each.findings[0] for each in found.values() if each.verdict == "missing" and each.findings]
    every = [finding for each in found.values() for finding in each.findings]
    plans = []
    if any(finding.tied_with for finding in every):
        words = ("plan", *bags, *validate, "-m", model, *reading, "-o", "drive")
        plans = [f"{command(*words)}   (a test that breaks the tie)"]
    if not effects:
        return ["next:", *(f"  {text}" for text in plans), ""] if plans else []
    given = [*bags, *(word for bag in validate for word in ("--validate", bag))]
    lines = [command("improve", *given, "-m", model, *reading, "-o", "improved.yaml")]
    if any(finding.is_channel for finding in every):
        lines = [f"{lines[0]} --signals-out map.yaml"]
    elif len(found) == 1:
        added = command("add", effects[0].effect, "-m", model, "-o", "more.yaml")
        lines.insert(0, f"{added}   (then fit and compare), or")
    return ["next:", *(f"  {text}" for text in [*lines, *plans]), ""]


def print_improvement(damper: str, found: Improvement, written: Sequence[Path], signals_out: Path | None) -> None:
    """Prints one damper: outcome, faults of the recordings, error over the steps, corrections and files."""
    print(f"{damper}: {found.sentence}")
    print_findings(first_diagnosis(found).data)
    names = [f"{step_name(step)}{f' ({step.effect})' if step.effect else ''}" for step in found.steps]
    width = max(map(len, (*names, "form-free reference")))
    lines = [f"  {'step':<{width}}  {'unseen':>9}  {'fitted':>9}"]
    for name, step in zip(names, found.steps, strict=True):
        row = f"  {name:<{width}}  {number(step.rmse_unseen_n):>7} N  {number(step.rmse_fit_n):>7} N"
        lines.append(f"{row}  {step.note if step.action != 'start' else ''}".rstrip())
    lines.append(f"  {'form-free reference':<{width}}  {number(found.reference_n):>7} N")
    lines.append(f"  {'noise floor':<{width}}  {number(found.noise_floor_n):>7} N")
    corrections = correction_rows(found)
    if found.final.stretches:
        lines.append(_wrapped(stretches_sentence(found.final), "  "))
    if corrections:
        lines.append("  corrections of the measurement chain, for the signal map, not for the model:")
        lines += [f"    {m['name']}: {m['before']} -> {m['after']} {m['unit']}".rstrip() for m in corrections]
        if signals_out is None:
            lines.append("    not written yet: use --signals-out MAP.yaml")
    print(*lines, *(f"  wrote {path}" for path in written), sep="\n")
