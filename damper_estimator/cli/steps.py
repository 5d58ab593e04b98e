"""The step test for ``compare --steps``: a record and a line per step."""

from collections.abc import Sequence

from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.validation.step_check import Step, step_check


def step_records(model: DamperModel, measurements: Sequence[Measurement]) -> list[dict[str, object]]:
    """What a model makes of every step of the recordings, for JSON.

    Raises:
        InputError: where a recording holds no step.
    """
    return [_record(step, m.recording) for m in measurements for step in step_check(model, m)]


def _record(step: Step, recording: str) -> dict[str, object]:
    return {
        "bag": recording,
        "time_s": step.time,
        "seconds": step.seconds,
        "height_m": step.height,
        "peak_velocity": step.peak_velocity,
        **step.measures.record(),
    }


def step_line(record: dict) -> str:
    """One step for people."""
    return (
        f"    at {record['time_s']:.2f} s: {1e3 * record['height_m']:+.0f} mm in {record['seconds']:.2f} s, peak "
        f"{record['peak_velocity']:+.2f} m/s: rms error {record['rmse_n']:.4g} N "
        f"({100 * record['nrmse']:.1f} % of the force), correlation {record['correlation']:.3f}"
    )
