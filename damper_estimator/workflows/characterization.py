"""Characteristic diagrams of dampers, their pattern types, and the model structure that follows from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from damper_estimator.characterization import (
    Characterization,
    Diagram,
    QuasiStatic,
    peaks,
    quasi_static,
    record,
    structure_model,
)
from damper_estimator.characterization import (
    characterize as characterized,
)
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.workflows.cases import Case
from damper_estimator.workflows.recording import Recording, checked
from damper_estimator.workflows.results import Results


@dataclass(frozen=True)
class DamperCharacterized:
    """One damper: its diagrams, and the quasi-static force that was subtracted first (None: nothing was)."""

    found: Characterization
    slow: QuasiStatic | None


@dataclass(frozen=True, repr=False, eq=False)
class CharacterizationResults(Results[DamperCharacterized]):
    """Diagrams and pattern types by damper."""

    @property
    def characterization(self) -> Characterization:
        """The complete characterization of one damper."""
        return self.only.found

    @property
    def diagrams(self) -> tuple[Diagram, ...]:
        """The operating points: mean loops of force over displacement, velocity and acceleration."""
        return tuple(self.only.found.diagrams)

    @property
    def sentence(self) -> str:
        """The operating points, their pattern types, and the structure that follows, in words."""
        found = self.only.found
        structure = "" if found.structure is None else f"; structure {found.structure.library_name}"
        return f"{self._line(self.only)}{structure}"

    @property
    def structure(self) -> DamperModel:
        """The structure that follows from the pattern types, as a model to fit.

        Raises:
            InputError: if no frequency band has a type.
        """
        return structure_of(self.only.found)

    def page(self) -> str:
        """One self-contained HTML page with the diagrams."""
        from damper_estimator.report import characteristic_page

        return characteristic_page([result.found for result in self.by_damper.values()])

    def _record(self, result: DamperCharacterized) -> dict[str, object]:
        return record(result.found)

    def _line(self, result: DamperCharacterized) -> str:
        types = [f"{b.low:g} to {b.high:g} Hz type {b.passive}" for b in result.found.bands if b.passive is not None]
        return f"{len(result.found.diagrams)} operating points, {', '.join(types) or 'no type'}"

    def _rows(self, result: DamperCharacterized) -> list[dict[str, object]]:
        return [dict(peaks(diagram.loop)) for diagram in result.found.diagrams]

    def _figure(self, result: DamperCharacterized) -> Mapping[str, object]:
        from damper_estimator.report import loops_over_velocity

        return loops_over_velocity(result.found.diagrams)


def characterize(
    recording: Recording, *, subtract: Recording | None = None, slow: Recording | None = None
) -> CharacterizationResults:
    """Averages the cycles of each frequency, amplitude and command, and names the type of their patterns.

    Args:
        recording: sines, or a sweep; dampers without a force are left out.
        subtract: the same motion at another setting (current, pressure, adjuster).
        slow: a slow test (about 5 mm/s) whose force over displacement is subtracted first.

    Raises:
        InputError: without a measured force, and without a complete cycle.
    """
    found = {}
    for damper, measurements in checked(recording).with_force("characterize").measurements.items():
        others = [] if subtract is None else _of(subtract, damper)
        still = None if slow is None else quasi_static(_of(slow, damper)[0])
        found[damper] = DamperCharacterized(characterized(measurements, others, still), still)
    return CharacterizationResults({"bags": list(recording.names)}, found)


def characterize_case(case: Case) -> CharacterizationResults:
    """The diagrams of one damper from all recordings of a case; raises InputError as `characterize`."""
    measurements = (*case.fit, *case.unseen)
    names = list(dict.fromkeys(measurement.recording for measurement in measurements))
    found = DamperCharacterized(characterized(measurements, [], None), None)
    return CharacterizationResults({"bags": names}, {case.damper: found})


def structure_of(found: Characterization) -> DamperModel:
    """The structure of a damper's patterns as a model.

    Raises:
        InputError: if no frequency band has a type.
    """
    if found.structure is None:
        raise InputError(
            f"{found.recordings[0]}: no band of damper {found.damper} has a type, so no structure follows; "
            "drive sines between 0.5 and 15 Hz"
        )
    return structure_model(found.structure)


def _of(recording: Recording, damper: str) -> list[Measurement]:
    return list(recording.of(damper).with_force("characterize").measurements[damper])
