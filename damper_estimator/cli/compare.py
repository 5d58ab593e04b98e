"""Compare a model with the measured force, and show where it fails.

Measured and modelled force pass the same filters; samples count from 0.2 s after each reset, except where the gauge
clipped. The gauge's zero and drift are reported separately and excluded from the regions of operation with large
errors. Faults of the measurement chain are reported with remedies. Several recordings are pooled and also reported one
by one; several models (-m repeated) are compared with each other. Errors are also reported by the frequency of the
excitation and by groups of velocity and frequency, formed from the recordings or given by --group.
"""

import argparse
import math
from collections.abc import Mapping
from pathlib import Path

from damper_estimator.cli.data_finding_text import print_findings
from damper_estimator.cli.recording_groups import parse_groups
from damper_estimator.cli.verb_support import (
    add_bags,
    add_models,
    add_reading,
    open_recordings,
    prints_text,
    report_notes,
    write_json,
    write_page,
)
from damper_estimator.validation import Comparison, per_recording
from damper_estimator.workflows import ModelsCompared, compare, comparison_request, in_words, no_force_error, page_title

EXAMPLES = (
    "compare hidden_unseen.mcap -m mine.yaml --html comparison.html",
    "compare passenger_dyno.mcap passenger_road.mcap -m mine.yaml -m linear_viscous --json -",
)
_REGIONS = 5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG... -m MODEL [-m MODEL]`` and the common arguments."""
    add_bags(parser)
    add_models(parser, several=True)
    parser.add_argument(
        "--group", metavar="NAME=BAG,...", action="append", default=[],
        help="report the joint error of these recordings under a name; may be repeated",
    )  # fmt: skip
    parser.add_argument("--steps", action="store_true", help="step test: judge each step of 10 mm or more separately")
    add_reading(parser, html=True)


def run(arguments: argparse.Namespace) -> int:
    """Compares one damper at a time, to keep the samples of only one in memory."""
    groups = parse_groups(arguments.group, arguments.bags)
    records: dict[str, object] = {}
    sections, notes = [], []
    with open_recordings(arguments) as reader:
        for name in reader.dampers:
            recording = reader.damper(name).where_force()
            notes += recording.notes
            if not recording.dampers:
                continue
            found = compare(recording, arguments.models, groups=groups, steps=arguments.steps).only
            records[name] = found.record()
            if prints_text(arguments):
                _print(name, found)
            if arguments.html:
                from damper_estimator.report import damper_section

                sections.append(damper_section(found.comparisons, len(reader.dampers)))
    if not records:
        raise no_force_error(str(arguments.bags[0]), "compare")
    report_notes(notes)
    bags = [str(path) for path in arguments.bags]
    if arguments.html:
        from damper_estimator.report import comparison_page

        write_page(arguments.html, comparison_page(sections, page_title(sections, in_words(bags))))
    write_json(arguments.json, comparison_request(bags, arguments.models) | {"dampers": records})
    return 0


def _print(name: str, found: ModelsCompared) -> None:
    comparisons = found.comparisons
    print(f"{name}  ({comparisons[0].measures.samples} samples of {len(comparisons[0].traces)} recording(s))")
    width = max(len(c.model.name) for c in comparisons)
    print(f"  {'model':{width}}  rms error  of force     ESR     fit  correlation  energy  bias")
    for c in comparisons:
        _print_row(c.model.name, width, c.measures.record())
        if len(c.traces) > 1:
            for part in per_recording(c):
                _print_row(f"  {Path(part.recordings[0]).name}", width, part.measures.record())
    for c in comparisons:
        for warning in c.warnings:
            print(f"  note: {warning}")
    print_findings(comparisons[0].findings)
    for c in comparisons:
        _print_regions(c, len(comparisons) > 1)
    for c in comparisons:
        _print_excitations(c, len(comparisons) > 1)
    for model, steps in (found.steps or {}).items():
        print(f"  steps, {model}:")
        print(*(_step_line(step) for step in steps), sep="\n")


def _print_row(label: str, width: int, m: Mapping[str, float]) -> None:
    print(
        f"  {label:{width}}  {m['rmse_n']:7.4g} N  {100 * m['nrmse']:6.1f} %  {m['esr']:6.4f}  "
        f"{m['fit_percent']:4.0f} %  {_cell(m['correlation'], '11.4f')}  {_cell(100 * m['energy_error'], '+4.0f')} %  "
        f"{m['bias_n']:+.4g} N"
    )


def _cell(value: float, form: str) -> str:
    """A number of this form; a dash as wide where it has no meaning, as the correlation of a constant."""
    return f"{value:{form}}" if math.isfinite(value) else "–".rjust(len(f"{0.0:{form}}"))


def _print_regions(comparison: Comparison, named: bool) -> None:
    of = f" of {comparison.model.name}" if named else ""
    floor, parts = comparison.noise_floor_n, comparison.split
    floor_text = f"; noise floor {floor:.3g} N" if floor == floor else ""
    print(
        f"  the error{of}: zero {parts.offset_n:+.3g} N, drift {parts.drift_n:.3g} N, gain {100 * parts.gain:+.2g} % "
        f"({parts.gain_n:.3g} N), scatter {parts.scatter_n:.3g} N rms{floor_text}"
    )
    for sentence in parts.sentences:
        print(f"    {sentence}")
    if not comparison.regions:
        rest = "the rest" if parts.sentences else "the error"
        print(f"  {rest}{of} is spread evenly over the range of operation")
        return
    print(f"  regions with large errors{of}:")
    for region in comparison.regions[:_REGIONS]:
        print(f"    {region.sentence}")


def _print_excitations(comparison: Comparison, named: bool) -> None:
    of = f" of {comparison.model.name}" if named else ""
    for group in comparison.groups:
        low, high = group.peak_velocity_m_s
        slow, fast = group.frequency_hz
        span = f"{low:.2g} to {high:.2g} m/s, {slow:.2g} to {fast:.2g} Hz, {group.cycles} cycles"
        print(f"  {group.name}{of}: {group.rmse_n:.4g} N rms, {100 * group.relative_rms:.3g} % of force ({span})")


def _step_line(record: Mapping) -> str:
    return (
        f"    at {record['time_s']:.2f} s: {1e3 * record['height_m']:+.0f} mm in {record['seconds']:.2f} s, peak "
        f"{record['peak_velocity']:+.2f} m/s: rms error {record['rmse_n']:.4g} N "
        f"({100 * record['nrmse']:.1f} % of the force), correlation {record['correlation']:.3f}"
    )
