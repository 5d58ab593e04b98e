"""Displacement or force in another unit than the signal map says: no damper moves or resists like that."""

from collections.abc import Iterator

import numpy as np

from damper_estimator.signals import DamperSignals, Measurement, usual_range
from damper_estimator.validation.finding import DataFinding, entry

LONGEST = 2.0  # m of stroke
FASTEST = 30.0  # m/s
SOFTEST = 10.0  # N s/m, rms of the force over that of the velocity: of a bicycle's damper some hundred
_STRONGEST_IN_KN = 100.0  # largest force that can be in kN
_FOLLOWING = 0.9  # of the force's square that is left by velocity and displacement, if it follows them
_SLOWEST = 1e-3  # m/s: below, there is no motion to compare with


def unit_findings(m: Measurement) -> Iterator[DataFinding]:
    """What is probably in millimetres or kilonewtons."""
    k = m.kinematics
    warm = k.warm()
    if not warm.any():
        return
    stroke, speed = usual_range(k.displacement[warm]), float(np.quantile(np.abs(k.velocity[warm]), 0.999))
    if stroke > LONGEST or speed > FASTEST:
        yield _in_millimetres(m, f"the displacement spans {stroke:.3g} m at up to {speed:.3g} m/s")
        return
    judged = m.judged if m.force is not None else np.zeros(len(k), bool)
    if not judged.any():
        return
    force, velocity = float(np.std(m.force[judged])), float(np.std(k.velocity[judged]))
    if velocity < _SLOWEST or not 0.0 < force < SOFTEST * velocity or not _follows(m, judged):
        return
    shown = f"the force has {force:.2g} N rms at {velocity:.2g} m/s rms, {force / velocity:.2g} N s/m"
    if float(np.max(np.abs(m.force[judged]))) > _STRONGEST_IN_KN:
        yield _in_millimetres(m, shown)
    else:
        yield _finding(m, f"{shown}: probably it is in kN", "force", 1e3)


def _follows(m: Measurement, judged: np.ndarray) -> bool:
    """Whether the force follows the motion at all, in any unit; noise does not."""
    k = m.kinematics
    columns = np.stack([k.velocity[judged], k.displacement[judged], np.ones(judged.sum())], axis=1)
    force = m.force[judged]
    left = force - columns @ np.linalg.lstsq(columns, force, rcond=None)[0]
    return bool(np.var(left) < _FOLLOWING * np.var(force))


def _in_millimetres(m: Measurement, shown: str) -> DataFinding:
    return _finding(m, f"{shown}: probably the displacement is in mm", "displacement", 1e-3)


def _finding(m: Measurement, sentence: str, role: str, factor: float) -> DataFinding:
    return DataFinding("unit", sentence, _remedy(role, m.signals, factor), m.recording, 1.0)


def in_millimetres(displacement: np.ndarray, signals: DamperSignals) -> str:
    """Why a displacement (n,) m is probably in mm, and what to do about it; "" if its stroke is possible."""
    stroke = usual_range(displacement)
    if stroke <= LONGEST:
        return ""
    return f"the displacement spans {stroke:.3g} m: probably it is in mm; {_remedy('displacement', signals, 1e-3)}"


def _remedy(role: str, signals: DamperSignals, factor: float) -> str:
    """What to change in the signal map if a channel's unit is ``factor`` SI units."""
    channel = getattr(signals, role)
    if channel.table is not None:
        return f"if so, multiply the values of the {role}'s table by {factor:g}"
    return f"if so, `{entry(role, signals, scale=factor * channel.scale)}` in the signal map"
