"""Determine characteristic diagrams (F-x, F-v, F-a), their pattern types, and a matching model structure.

Cycles of equal frequency, amplitude and command are averaged over phase, without the first of each passage. With
several commands the semi-active part is the force that a command adds to the smallest one at the same motion. The
types, 0 to 6, are those of Lozoya-Santos et al., for 0.5 to 3, 3 to 7 and 7 to 15 Hz. -o writes the structure as a
model for fit.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from damper_estimator.characterization import MEANINGS, Characterization, Diagram, QuasiStatic, peaks, peaks_csv
from damper_estimator.cli.verb_support import (
    add_bags,
    add_reading,
    prints_text,
    progress,
    read_recordings,
    report_notes,
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
    """``BAG... [--subtract BAG] [--quasi-static BAG] [--peaks FILE] [-o MODEL.yaml]`` and the common arguments."""
    add_bags(parser)
    parser.add_argument(
        "--subtract", metavar="BAG", type=Path, action="append", default=[],
        help="the same motion at another setting (current, pressure, adjuster), to be subtracted; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--quasi-static", metavar="BAG", type=Path, dest="slow",
        help="a slow test (about 5 mm/s); its force over displacement and direction is subtracted first",
    )  # fmt: skip
    parser.add_argument(
        "--peaks", metavar="FILE.csv", type=Path, help="write peak velocities and their forces as a table"
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="MODEL.yaml",
        type=Path,
        help="write the structure as a model to fit; a folder for several dampers",
    )
    add_reading(parser, html=True)


def run(arguments: argparse.Namespace) -> int:
    """Characterizes every damper."""
    recording = read_recordings(arguments).with_force("characterize")
    report_notes(recording.notes)
    subtract = read_recordings(arguments, arguments.subtract, whole=True) if arguments.subtract else None
    slow = read_recordings(arguments, [arguments.slow], whole=True) if arguments.slow else None
    results = characterize(recording, subtract=subtract, slow=slow)
    if prints_text(arguments):
        for result in results.by_damper.values():
            print(text(result.found, result.slow))
    _write(arguments, results)
    return 0


def _write(arguments: argparse.Namespace, results: CharacterizationResults) -> None:
    for damper, result in results.by_damper.items():
        if arguments.peaks:
            write_text(_target(arguments.peaks, damper, len(results)), peaks_csv(result.found.diagrams))
        if arguments.output:
            save_model(structure_of(result.found), _target(arguments.output, damper, len(results)))
    write_json(arguments.json, results.to_dict())
    if arguments.html:
        results.save(arguments.html)
        progress(f"wrote {arguments.html}")


def _target(path: Path, damper: str, dampers: int) -> Path:
    """The file of a damper: the path itself; with several dampers prefixed by the damper's name, or in a folder."""
    if path.is_dir() or (dampers > 1 and not path.suffix):
        path.mkdir(parents=True, exist_ok=True)
        return path / f"{damper}.yaml"
    return path if dampers == 1 else path.with_name(f"{damper}_{path.name}")


def text(found: Characterization, slow: QuasiStatic | None) -> str:
    """The results as text."""
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
    """Points of the fastest motion; the JSON file and the page have all."""
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
