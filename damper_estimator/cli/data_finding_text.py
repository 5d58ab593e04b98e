"""Prints faults of the measurement chain that recordings reveal."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from damper_estimator.validation import DataFinding, data_findings
from damper_estimator.workflows import Recording


def spoiled(recording: Recording) -> Iterator[str]:
    """Notes on recordings from which nothing that is identified means anything."""
    for damper, measurements in recording.measurements.items():
        for finding in data_findings(None, measurements):
            if finding.spoils:
                yield f"{Path(finding.recording).name}: {damper}: {finding.sentence}; {finding.remedy}"


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
