"""A characterization as JSON and its peaks as a table like Table 1 of the HIS paper."""

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from damper_estimator.characterization.characteristics import Characterization, Diagram
from damper_estimator.characterization.loops import Loop
from damper_estimator.characterization.model_structure import Structure

PEAK_COLUMNS = (
    "frequency_hz", "amplitude_m", "command", "pressure_pa", "cycles", "peak_velocity_rebound_m_s", "force_rebound_n",
    "peak_velocity_compression_m_s", "force_compression_n", "largest_force_n", "smallest_force_n",
)  # fmt: skip
_LOOP_STEP = 4  # JSON has every fourth of 360 phases


def peaks(loop: Loop) -> dict[str, float]:
    """The force where the speed peaks, in both directions (the largest force is a separate value); SI."""
    top, bottom = int(np.argmax(loop.velocity)), int(np.argmin(loop.velocity))
    values = (
        loop.frequency, loop.amplitude, loop.command, loop.pressure, loop.cycles, loop.velocity[top], loop.force[top],
        loop.velocity[bottom], loop.force[bottom], loop.force.max(), loop.force.min(),
    )  # fmt: skip
    return dict(zip(PEAK_COLUMNS, map(float, values), strict=True)) | {"cycles": loop.cycles}


def peaks_csv(diagrams: Sequence[Diagram]) -> str:
    """The peaks of all operating points by rising peak velocity; unknown values are empty."""
    rows = sorted((peaks(d.loop) for d in diagrams), key=lambda row: row["peak_velocity_rebound_m_s"])
    lines = [",".join("" if value != value else f"{value:.6g}" for value in row.values()) for row in rows]
    return "\n".join([",".join(PEAK_COLUMNS), *lines]) + "\n"


def record(found: Characterization) -> dict[str, object]:
    """For JSON; NaN means not available."""
    return {
        "bags": list(found.recordings),
        "operating_points": [_diagram(d) for d in found.diagrams],
        "differences": [_diagram(d) for d in found.differences],
        "bands": [asdict(band) for band in found.bands],
        "structure": _structure(found.structure) if found.structure else None,
        "notes": list(found.notes),
    }


def _diagram(diagram: Diagram) -> dict[str, object]:
    loop, pattern = diagram.loop, asdict(diagram.pattern)
    thinned = {
        name: getattr(loop, name)[::_LOOP_STEP]
        for name in ("displacement", "velocity", "acceleration", "force", "spread")
    }
    return {
        "role": diagram.role,
        "subtracted_setting": diagram.subtrahend,
        **peaks(loop),
        "steady": loop.steady,
        "bags": list(loop.recordings),
        "type": pattern.pop("type"),
        "because": pattern.pop("because"),
        "measures": pattern,
        "points": {name: asdict(point) for name, point in diagram.points.items()},
        "lines": {name: asdict(line) for name, line in diagram.lines.items()},
        "loop": thinned,
    }


def _structure(structure: Structure) -> dict[str, object]:
    return asdict(structure) | {"model": structure.library_name}
