"""From a linear damper to the model that real recordings justify: `improve` on all commands of a damper together.

    python benchmarks/real_story.py [-o docs/real_data.md]

Judged on recordings outside the fit: another frequency, another amplitude, and omitted currents.
"""

import argparse
import os
import tempfile
from pathlib import Path

from real_data import DATA, LABCONTROL, UTFSM, import_all

from damper_estimator import files
from damper_estimator.diagnosis import Diagnosis, Improvement, improve
from damper_estimator.identification import fit
from damper_estimator.model import load_model
from damper_estimator.numbers import plus_minus
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, SignalMap, measure
from damper_estimator.signals.channels import damper_names

BEGIN, END = "<!-- steps -->", "<!-- end of steps -->"
UTFSM_LEFT_OUT = ("0.25 A", "0.75 A")


def read(folder: Path, paths: list[str]) -> list[Measurement]:
    """The measured channels of recordings."""
    measurements = []
    for path in paths:
        with open_bag(folder / path) as bag:
            measurements.append(measure(bag, SignalMap(), damper_names(bag)[0]))
    return measurements


def story(folder: Path, fitted: list[str], unseen: list[str]) -> Improvement:
    """The result of `improve` from a linear damper."""
    seen = read(folder, fitted)
    linear = fit(load_model("linear_viscous"), seen).model
    return improve(linear, seen, read(folder, unseen), workers=os.cpu_count() or 1)


def steps_table(improvement: Improvement) -> str:
    """The steps as a table with their findings and ties, and the remaining error."""
    force = improvement.first.force_rms_n
    rows = ["| step | unseen error | of the force | tied with |", "| --- | ---: | ---: | --- |"]
    for step in improvement.steps:
        name = step.action if step.effect is None else f"{step.action} {step.effect} ({step.phenomenon or 'curve'})"
        tied = _tied(step.diagnosis, step.effect)
        rows.append(f"| {name} | {step.rmse_unseen_n:.1f} N | {100.0 * step.rmse_unseen_n / force:.1f} % | {tied} |")
    rows.append(
        f"| noise floor | {improvement.noise_floor_n:.1f} N | {100.0 * improvement.noise_floor_n / force:.1f} % | |"
    )
    errors = improvement.model.fit.get("standard_errors", {})
    values = [
        f"`{slot.address}` {slot.value:.3g} {slot.parameter.unit} "
        f"({plus_minus(slot.value, errors.get(slot.address, float('nan')))})"
        for slot in improvement.model.slots
    ]
    return "\n".join(rows) + f"\n\nThe model: {', '.join(values)}.\n\nFinal diagnosis: {improvement.final.sentence}"


def _tied(diagnosis: Diagnosis | None, effect: str | None) -> str:
    found = [one for one in diagnosis.findings if one.effect == effect] if diagnosis else []
    return ", ".join(found[0].tied_with) if found else ""


def main() -> None:
    """Prints the steps on both sets and writes them to a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    if not DATA.is_dir():
        raise SystemExit(f"{DATA}: the real recordings are missing; set DAMPER_SHARED_DATA")
    parts = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        import_all(folder)
        for title, settings, left_out in (
            ("utfsm_mr_damper", UTFSM, UTFSM_LEFT_OUT), ("labcontrol_mr_damper", LABCONTROL, ()),
        ):  # fmt: skip
            fitted = [path for setting in settings if setting.name not in left_out for path in setting.fitted]
            unseen = [path for setting in settings for path in setting.unseen]
            parts += [f"### {title}, from a linear damper", steps_table(story(folder, fitted, unseen))]
    text = "\n\n".join(parts) + "\n"
    print(text)
    if arguments.output:
        page = arguments.output.read_text(encoding="utf-8")
        before, _, rest = page.partition(BEGIN)
        files.write_text(arguments.output, f"{before}{BEGIN}\n\n{text}\n{END}{rest.partition(END)[2]}")


if __name__ == "__main__":
    main()
