"""Prints what recordings show to be wrong with the measurement chain."""

from collections.abc import Sequence
from pathlib import Path

from damper_estimator.validation import DataFinding


def print_findings(findings: Sequence[DataFinding]) -> None:
    """Each finding and its remedy; those that several recordings share are told once."""
    same: dict[tuple[str, str], list[str]] = {}
    for finding in findings:
        same.setdefault((finding.sentence, finding.remedy), []).append(Path(finding.recording).name)
    several = len({finding.recording for finding in findings}) > 1
    for (sentence, remedy), names in same.items():
        where = (
            f" ({', '.join(names) if len(names) <= 3 else f'{len(names)} recordings'})" if several and names[0] else ""
        )
        print(f"  data: {sentence}{where}")
        print(f"    remedy: {remedy}")
