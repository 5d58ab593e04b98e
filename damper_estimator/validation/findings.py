"""Mistakes of the measurement chain that the recordings show by themselves: data before physics."""

from collections.abc import Sequence

from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.validation.channel_findings import channel_findings
from damper_estimator.validation.finding import DataFinding
from damper_estimator.validation.force_findings import force_findings
from damper_estimator.validation.magnitudes import unit_findings


def data_findings(model: DamperModel | None, measurements: Sequence[Measurement]) -> tuple[DataFinding, ...]:
    """The mistakes in the recordings of one damper, whatever a model lacks.

    A model only helps to decide which of two channels has the wrong sign. Skew, gain, offset and
    spring rate that show against a model alone are candidates of the diagnosis.
    """
    found = [finding for m in measurements for finding in channel_findings(m)]
    units = [finding for m in _unspoiled(measurements, found) for finding in unit_findings(m)]
    # Parts of one recording have the same unit, shown with other numbers.
    found += {(finding.recording, finding.remedy): finding for finding in reversed(units)}.values()
    alive = [m for m in _unspoiled(measurements, found) if m.force is not None and m.judged.any()]
    # Parts of one recording repeat the findings of their channels.
    return tuple(dict.fromkeys([*found, *force_findings(model, alive)]))


def _unspoiled(measurements: Sequence[Measurement], found: Sequence[DataFinding]) -> list[Measurement]:
    spoiled = {finding.recording for finding in found if finding.spoils}
    return [m for m in measurements if m.recording not in spoiled]
