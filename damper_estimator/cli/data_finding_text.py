"""Prints faults of the measurement chain that recordings reveal."""

from collections.abc import Sequence
from pathlib import Path

from damper_estimator.validation import DataFinding


def print_findings(findings: Sequence[DataFinding]) -> None:
    """Prints each finding with its remedy; equal findings of several recordings are printed once."""
    recordings: dict[tuple[str, str], list[str]] = {}
    for finding in findings:
        recordings.setdefault((finding.sentence, finding.remedy), []).append(Path(finding.recording).name)
    several = len({finding.recording for finding in findings}) > 1
    for (sentence, remedy), names in recordings.items():
        where = (
            f" ({', '.join(names) if len(names) <= 3 else f'{len(names)} recordings'})" if several and names[0] else ""
        )
        print(f"  data: {sentence}{where}")
        print(f"    remedy: {remedy}")
