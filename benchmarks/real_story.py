"""From a linear damper to what real recordings justify: `improve` on all commands of a damper together.

    python benchmarks/real_story.py [-o docs/real_data.md]

Judged on recordings that no fit has seen: another frequency, another amplitude, and currents that were left out.
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
    """What `improve` makes of a linear damper."""
    seen = read(folder, fitted)
    linear = fit(load_model("linear_viscous"), seen).model
    return improve(linear, seen, read(folder, unseen), workers=os.cpu_count() or 1)


def told(own: Improvement) -> str:
    """The steps as a table, what each found and could not tell, and what is left."""
    force = own.first.force_rms_n
    rows = ["| step | unseen error | of the force | tied with |", "| --- | ---: | ---: | --- |"]
    for step in own.steps:
        name = step.action if step.effect is None else f"{step.action} {step.effect} ({step.phenomenon})"
        tied = _tied(step.diagnosis, step.effect)
        rows.append(f"| {name} | {step.rmse_unseen_n:.1f} N | {100.0 * step.rmse_unseen_n / force:.1f} % | {tied} |")
    rows.append(f"| noise floor | {own.noise_floor_n:.1f} N | {100.0 * own.noise_floor_n / force:.1f} % | |")
    errors = own.model.fit.get("standard_errors", {})
    values = [
        f"`{slot.address}` {slot.value:.3g} ± {errors.get(slot.address, float('nan')):.1g} {slot.parameter.unit}"
        for slot in own.model.slots
    ]
    return "\n".join(rows) + f"\n\nThe model: {', '.join(values)}.\n\nAsked once more: {own.final.sentence}"


def _tied(diagnosis: Diagnosis | None, effect: str | None) -> str:
    found = [one for one in diagnosis.findings if one.effect == effect] if diagnosis else []
    return ", ".join(found[0].tied_with) if found else ""


def main() -> None:
    """Prints the steps on both sets, and writes them into a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    if not DATA.is_dir():
        raise SystemExit(f"{DATA}: the real recordings are not there; set DAMPER_SHARED_DATA")
    parts = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        import_all(folder)
        for title, settings, left_out in (
            ("utfsm_mr_damper", UTFSM, UTFSM_LEFT_OUT), ("labcontrol_mr_damper", LABCONTROL, ()),
        ):  # fmt: skip
            fitted = [path for own in settings if own.name not in left_out for path in own.fitted]
            unseen = [path for own in settings for path in own.unseen]
            parts += [f"### {title}, from a linear damper", told(story(folder, fitted, unseen))]
    text = "\n\n".join(parts) + "\n"
    print(text)
    if arguments.output:
        page = arguments.output.read_text(encoding="utf-8")
        before, _, rest = page.partition(BEGIN)
        files.write_text(arguments.output, f"{before}{BEGIN}\n\n{text}\n{END}{rest.partition(END)[2]}")


if __name__ == "__main__":
    main()
