"""How well a model agrees with the measurement, and where it fails.

Measured and modelled force pass the same filters; judged from 0.2 s after each reset on, where the gauge did not clip.
The gauge's zero and drift are told by themselves and left out of the regions of operation in which the error is.
Mistakes of the measurement chain that the recordings show are named with their mends: data before physics. Several
recordings are pooled and also told one by one; several models (-m repeated) stand side by side. Errors are also told
by the excitation's frequency and by groups of velocity and frequency, formed from the recordings' own ranges or given
by --group.
"""

import argparse
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from damper_estimator.cli.common import (
    add_bags,
    add_html,
    add_json,
    add_models,
    add_signals,
    add_window,
    progress,
    write_json,
)
from damper_estimator.cli.data_findings import print_findings
from damper_estimator.cli.groups import parse_groups
from damper_estimator.cli.steps import step_line, step_records
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.model import load_model
from damper_estimator.recordings import Bag, open_bag
from damper_estimator.signals import Measurement, SignalMap, load_signal_map, measure
from damper_estimator.signals.channels import signals_for
from damper_estimator.validation import Comparison, compare, per_recording
from damper_estimator.validation.spectra import partial_coherence
from damper_estimator.validation.velocity import velocity_agreement

_REGIONS = 5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG... -m MODEL [-m MODEL]`` and what is common."""
    add_bags(parser)
    add_models(parser, several=True)
    parser.add_argument(
        "--group", metavar="NAME=BAG,...", action="append", default=[],
        help="tell the error of these recordings together under a name; may be repeated",
    )  # fmt: skip
    parser.add_argument("--steps", action="store_true", help="step test: judge every step of 10 mm and more by itself")
    add_signals(parser)
    add_window(parser)
    add_json(parser)
    add_html(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compares; see the module's docstring."""
    grouping = parse_groups(arguments.group, arguments.bags)
    records: dict[str, object] = {}
    sections, notes = [], []
    with ExitStack() as stack:
        bags = [stack.enter_context(open_bag(path)) for path in arguments.bags]
        chosen = _dampers(bags, load_signal_map(arguments.signals), arguments.dampers)
        for name, own in chosen.items():
            measurements, missing = _measurements(own, name, arguments)
            notes += missing
            if not measurements:
                continue
            judged = [compare(load_model(model, name), *measurements) for model in arguments.models]
            comparisons = [replace(comparison, grouping=grouping) for comparison in judged]
            records[name] = _record(comparisons, arguments.models)
            if arguments.json != "-":
                _print(name, comparisons)
            if arguments.steps:
                records[name] |= _steps(comparisons, arguments.json != "-")
            if arguments.html:
                from damper_estimator.report import damper_section

                sections.append(damper_section(comparisons, len(chosen)))
    if not records:
        raise InputError(
            f"{arguments.bags[0]}: no damper has a measured force; compare needs one (name its topic in a signal map)"
        )
    for note in notes:
        progress(note)
    if arguments.html:
        _write_page(arguments, sections)
    write_json(
        arguments.json, {"bags": [str(path) for path in arguments.bags], "models": arguments.models, "dampers": records}
    )
    return 0


def _write_page(arguments: argparse.Namespace, sections: Sequence) -> None:
    from damper_estimator.report import comparison_page

    models = " and ".join(sections[0].figures["models"])
    bags = arguments.bags[0].name if len(arguments.bags) == 1 else f"{len(arguments.bags)} recordings"
    write_text(arguments.html, comparison_page(sections, f"{models} against {bags}"))
    progress(f"wrote {arguments.html}")


def _dampers(
    bags: Sequence[Bag], signal_map: SignalMap, wanted: Sequence[str]
) -> dict[str, list[tuple[Bag, SignalMap]]]:
    """The bags that have each damper, in order of appearance, and the map to read it by.

    Raises:
        InputError: where a wanted damper is in none of the bags.
    """
    found: dict[str, list[tuple[Bag, SignalMap]]] = {}
    maps = [signals_for(bag, signal_map) for bag in bags]
    for bag, own in zip(bags, maps, strict=True):
        for name in own.dampers:
            if not wanted or name in wanted:
                found.setdefault(name, []).append((bag, own))
    for name in wanted:
        if name not in found:
            signals_for(bags[0], maps[0], name)
    return found


def _measurements(
    bags: Sequence[tuple[Bag, SignalMap]], name: str, arguments: argparse.Namespace
) -> tuple[list[Measurement], list[str]]:
    """The damper in all its bags, less those without its force, and notes on these."""
    start = 0.0 if arguments.start is None else arguments.start
    end = float("inf") if arguments.stop is None else arguments.stop
    asked = name in arguments.dampers
    measurements = [measure(bag, own, name, start, end, force_wanted=asked) for bag, own in bags]
    notes = [f"{m.recording}: the force of {name} was not measured; left out" for m in measurements if m.force is None]
    return [m for m in measurements if m.force is not None], notes


def _record(comparisons: Sequence[Comparison], models: Sequence[str]) -> dict[str, object]:
    """The first model's record; all models under ``models``, and where there are several bags each under ``bags``."""
    records = []
    for comparison, model in zip(comparisons, models, strict=True):
        record = comparison.record() | {"model_file": model}
        if len(comparison.traces) > 1:
            record["bags"] = [own.record() | {"bag": own.recordings[0]} for own in per_recording(comparison)]
        records.append(record)
    measurements = [t.measurement for t in comparisons[0].traces]
    velocities = {m.recording: own.record() for m in measurements if (own := velocity_agreement(m)) is not None}
    first = records[0] | {"partial_coherence": partial_coherence(measurements).record()}
    return first | ({"velocity": velocities} if velocities else {}) | ({"models": records} if len(records) > 1 else {})


def _steps(comparisons: Sequence[Comparison], printed: bool) -> dict[str, object]:
    """Every step by itself, under ``steps`` and the model's name; printed where wanted."""
    steps = {c.model.name: step_records(c.model, [t.measurement for t in c.traces]) for c in comparisons}
    for model, own in steps.items() if printed else ():
        print(f"  steps, {model}:")
        print(*(step_line(record) for record in own), sep="\n")
    return {"steps": steps}


def _print(name: str, comparisons: Sequence[Comparison]) -> None:
    print(f"{name}  ({comparisons[0].measures.samples} samples of {len(comparisons[0].traces)} recording(s))")
    width = max(len(c.model.name) for c in comparisons)
    print(f"  {'model':{width}}  rms error  of force     ESR     fit  correlation  energy  bias")
    for c in comparisons:
        _print_row(c.model.name, width, c.measures.record())
        if len(c.traces) > 1:
            for own in per_recording(c):
                _print_row(f"  {Path(own.recordings[0]).name}", width, own.measures.record())
    for c in comparisons:
        for warning in c.warnings:
            print(f"  note: {warning}")
    print_findings(comparisons[0].findings)
    for c in comparisons:
        _print_regions(c, len(comparisons) > 1)
    for c in comparisons:
        _print_excitations(c, len(comparisons) > 1)


def _print_row(label: str, width: int, m: Mapping[str, float]) -> None:
    print(
        f"  {label:{width}}  {m['rmse_n']:7.4g} N  {100 * m['nrmse']:6.1f} %  {m['esr']:6.4f}  "
        f"{m['fit_percent']:4.0f} %"
        f"  {m['correlation']:11.4f}  {100 * m['energy_error']:+4.0f} %  {m['bias_n']:+.4g} N"
    )


def _print_regions(comparison: Comparison, named: bool) -> None:
    of = f" of {comparison.model.name}" if named else ""
    floor, parts = comparison.noise_floor_n, comparison.split
    told = f"; noise floor {floor:.3g} N" if floor == floor else ""
    print(
        f"  the error{of}: zero {parts.offset_n:+.3g} N, drift {parts.drift_n:.3g} N, gain {100 * parts.gain:+.2g} % "
        f"({parts.gain_n:.3g} N), scatter {parts.scatter_n:.3g} N rms{told}"
    )
    for sentence in parts.sentences:
        print(f"    {sentence}")
    if not comparison.regions:
        rest = "the rest" if parts.sentences else "the error"
        print(f"  {rest}{of} is spread evenly over the operation")
        return
    print(f"  where the error{of} is:")
    for region in comparison.regions[:_REGIONS]:
        print(f"    {region.sentence}")


def _print_excitations(comparison: Comparison, named: bool) -> None:
    of = f" of {comparison.model.name}" if named else ""
    for group in comparison.groups:
        low, high = group.peak_velocity_m_s
        slow, fast = group.frequency_hz
        span = f"{low:.2g} to {high:.2g} m/s, {slow:.2g} to {fast:.2g} Hz, {group.cycles} cycles"
        print(f"  {group.name}{of}: {group.rmse_n:.4g} N rms, {100 * group.relative_rms:.3g} % of force ({span})")
