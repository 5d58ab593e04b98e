"""Characteristic diagrams (F-x, F-v, F-a), their pattern types, and the model structure that they call for.

Cycles of one frequency, amplitude and command are averaged over their phase; the first of each passage is left out.
With several commands the semi-active part is what a command adds to the smallest one at the same motion. Types are
those of Lozoya-Santos et al., 0 to 6, for 0.5 to 3, 3 to 7 and 7 to 15 Hz. -o writes the structure as a model that
fit takes.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from damper_estimator.characterization import MEANINGS, Characterization, Diagram, QuasiStatic, peaks, peaks_csv
from damper_estimator.cli.common import (
    STANDARD_OUTPUT,
    add_bags,
    add_html,
    add_json,
    add_signals,
    add_window,
    progress,
    read_asked,
    write_json,
)
from damper_estimator.files import write_text
from damper_estimator.model import save_model
from damper_estimator.workflows import CharacterizationResults, characterize, structure_of

EXAMPLES = (
    "characterize passenger_dyno.mcap --html diagrams.html",
    "characterize passenger_dyno.mcap --peaks peaks.csv -o structure.yaml",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """``BAG... [--subtract BAG] [--quasi-static BAG] [--peaks FILE] [-o MODEL.yaml]`` and what is common."""
    add_bags(parser)
    parser.add_argument(
        "--subtract", metavar="BAG", type=Path, action="append", default=[],
        help="the same motion at another setting (current, pressure, adjuster), to be subtracted; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--quasi-static", metavar="BAG", type=Path, dest="slow",
        help="a slow test (about 5 mm/s); its force over displacement and direction is taken from everything first",
    )  # fmt: skip
    parser.add_argument(
        "--peaks", metavar="FILE.csv", type=Path, help="write peak velocities and the forces there as a table"
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="MODEL.yaml",
        type=Path,
        help="write the structure as a model to fit; a folder for several dampers",
    )
    add_signals(parser)
    add_window(parser)
    add_json(parser)
    add_html(parser)


def run(arguments: argparse.Namespace) -> int:
    """Characterizes every damper; see the module's docstring."""
    recording = read_asked(arguments).with_force("characterize")
    for note in recording.notes:
        progress(note)
    subtract = read_asked(arguments, arguments.subtract, whole=True) if arguments.subtract else None
    slow = read_asked(arguments, [arguments.slow], whole=True) if arguments.slow else None
    results = characterize(recording, subtract=subtract, slow=slow)
    if arguments.json != STANDARD_OUTPUT:
        for own in results.by_damper.values():
            print(text(own.found, own.slow))
    _write(arguments, results)
    return 0


def _write(arguments: argparse.Namespace, results: CharacterizationResults) -> None:
    for damper, own in results.by_damper.items():
        if arguments.peaks:
            write_text(_target(arguments.peaks, damper, len(results)), peaks_csv(own.found.diagrams))
        if arguments.output:
            save_model(structure_of(own.found), _target(arguments.output, damper, len(results)))
    write_json(arguments.json, results.to_dict())
    if arguments.html:
        results.save(arguments.html)
        progress(f"wrote {arguments.html}")


def _target(path: Path, damper: str, dampers: int) -> Path:
    """The file itself; beside other dampers one with the damper's name in front, or inside a folder."""
    if path.is_dir() or (dampers > 1 and not path.suffix):
        path.mkdir(parents=True, exist_ok=True)
        return path / f"{damper}.yaml"
    return path if dampers == 1 else path.with_name(f"{damper}_{path.name}")


def text(found: Characterization, slow: QuasiStatic | None) -> str:
    """The result for people."""
    lines = [f"{found.damper}: {len(found.diagrams)} operating points in {len(found.recordings)} recording(s)"]
    if slow is not None:
        lines.append(f"  quasi-static force of {Path(slow.recording).name} ({1e3 * slow.speed:.3g} mm/s) subtracted")
    lines += ["", *_table(found.diagrams, "total force")]
    for role in dict.fromkeys(d.role for d in found.differences):
        lines += ["", *_table([d for d in found.differences if d.role == role], f"{role.replace('_', '-')} part")]
    lines += ["", *_points(found)]
    for band in found.bands:
        kinds = [
            f"{label} type {kind}"
            for label, kind in (("passive", band.passive), ("semi-active", band.semi_active))
            if kind is not None
        ]
        lines.append(f"  {band.low:g} to {band.high:g} Hz: {', '.join(kinds) or 'no type'}; {band.why}")
    if found.structure is not None:
        lines.append(f"  structure: {found.structure.library_name}; {found.structure.because}")
    return "\n".join([*lines, *(f"  note: {note}" for note in found.notes)])


def _table(diagrams: Sequence[Diagram], title: str) -> list[str]:
    head = f"  {title:<18} Hz      mm  command  cycles  m/s rebound   N there  m/s compr.   N there"
    head += "  type  low    high   symmetric"
    rows = []
    for d in diagrams:
        p, row = d.pattern, peaks(d.loop)
        command = "-" if d.loop.command != d.loop.command else f"{d.loop.command:.3g}"
        rows.append(
            f"  {'' if d.loop.steady else 'single cycles':<14}{d.loop.frequency:6.2f}  "
            f"{1e3 * d.loop.amplitude:6.2f}  {command:>7}  {d.loop.cycles:6d}"
            f"  {row['peak_velocity_rebound_m_s']:11.4f}  {row['force_rebound_n']:8.0f}  "
            f"{row['peak_velocity_compression_m_s']:10.4f}"
            f"  {row['force_compression_n']:8.0f}  {p.type:4d}  {100 * p.hysteresis_low:+5.1f}  "
            f"{100 * p.hysteresis_high:+5.1f}  {'yes' if p.symmetric else 'no'}"
        )
    return [head, *rows]


def _points(found: Characterization) -> list[str]:
    """Points of the fastest motion; all of them are in the JSON and on the page."""
    fastest = max(found.diagrams, key=lambda d: d.loop.peak_velocity)
    loop = fastest.loop
    lines = [
        f"  points at {loop.frequency:.3g} Hz, {1e3 * loop.amplitude:.3g} mm    x mm      v m/s    a m/s^2     "
        " F N   line to it: N s/m"
    ]
    for name, point in fastest.points.items():
        slope = fastest.lines[name.lower()].damping
        slope_text = f"{slope:.4g}" if slope == slope else "no length"
        lines.append(
            f"    {name}  {MEANINGS[name]:<24}{1e3 * point.displacement:8.2f}  {point.velocity:9.4f}  "
            f"{point.acceleration:9.3f}  {point.force:7.0f}   {slope_text}"
        )
    return lines
