"""The record of a fit in the model file: its origin, its error, and its region of validity."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

import numpy as np

from damper_estimator.identification.error_bound import force_stddev, worst_errors
from damper_estimator.identification.rows import force_rms
from damper_estimator.identification.samples import Channels, channels_of
from damper_estimator.model import DamperModel
from damper_estimator.runtime import REGION_ROWS
from damper_estimator.signals import Measurement

REGION = (0.1, 99.9)  # percentiles of the judged samples


def fit_record(
    model: DamperModel,
    measurements: Sequence[Measurement],
    residual_stddev: float,
    standard_errors: Mapping[str, float],
) -> dict[str, object]:
    """The mapping that is stored under ``fit`` in a model file.

    Args:
        model: as fitted.
        residual_stddev: N, in band.
        standard_errors: by address; those that are not known are left out.
    """
    names = list(dict.fromkeys(measurement.recording for measurement in measurements))
    first, region = measurements[0], region_of(channels_of(measurements))
    deviations = residual_stddev, force_stddev(worst_errors(model, measurements))
    return record_of(names, (first.cutoff, first.band), region, deviations, force_rms(measurements), standard_errors)


def record_of(
    bags: Sequence[str],
    filters: tuple[float, float],
    region: Mapping[str, Sequence[float]],
    deviations: tuple[float, float],
    force_rms: float,
    standard_errors: Mapping[str, float],
) -> dict[str, object]:
    """The same from the recordings' names, the filters' cutoff and band (Hz), the region of validity, and the standard
    deviations of the residual in band and of the force (`force_stddev`), and the rms of the measured force about its
    mean, N."""
    return {
        "bags": list(bags),
        "date": datetime.now(UTC).date().isoformat(),
        "cutoff": float(filters[0]),
        "band": float(filters[1]),
        **error_record(deviations, force_rms),
        "region": {name: list(ends) for name, ends in region.items()},
        "standard_errors": {
            name: float(f"{error:.6g}") for name, error in standard_errors.items() if np.isfinite(error)
        },
    }


def error_record(deviations: tuple[float, float], force_rms: float) -> dict[str, float]:
    """The part of it that states the error, from the same numbers."""
    return {
        "residual_stddev": float(f"{deviations[0]:.6g}"),
        "force_stddev": float(f"{np.max(deviations):.6g}"),
        "force_rms": float(f"{force_rms:.6g}"),
    }


def recorded(model: DamperModel, name: str) -> float:
    """A number of a model's record of its fit; NaN if it holds none of that name, as a file edited by hand may."""
    value = model.fit.get(name)
    return float(value) if isinstance(value, (int, float)) else float("nan")


def region_of(channels: Channels) -> dict[str, list[float]]:
    """Lowest and highest value of each recorded channel, without the outermost thousandth on either side."""
    values = {name: channels(row) for name, row in REGION_ROWS.items()}
    return {name: channel.percentiles(REGION) for name, channel in values.items() if channel.size}


def recorded_region(model: DamperModel, channel: str) -> tuple[float, float] | None:
    """Lowest and highest value of a channel that a model was identified at; None if its record does not say."""
    region = model.fit.get("region")
    try:
        low, high = (float(end) for end in region[channel])
    except (KeyError, TypeError, ValueError):
        return None
    return low, high


def in_region(block: np.ndarray, channel: str, low: float, high: float) -> np.ndarray:
    """(n,) bool, samples of a block whose channel is unknown or lies between two values."""
    return ~((block[REGION_ROWS[channel]] < low) | (block[REGION_ROWS[channel]] > high))
