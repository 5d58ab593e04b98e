"""What a fit leaves in the model file: where it comes from, how well it agrees, where it is valid."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

import numpy as np

from damper_estimator.identification.samples import Channels, channels_of
from damper_estimator.runtime import REGION_ROWS
from damper_estimator.signals import Measurement

REGION = (0.1, 99.9)  # percentiles of the judged samples


def fit_record(
    measurements: Sequence[Measurement], residual_stddev: float, standard_errors: Mapping[str, float]
) -> dict[str, object]:
    """The mapping that is stored under ``fit`` in a model file.

    Args:
        residual_stddev: N, in band.
        standard_errors: by address; those that are not known are left out.
    """
    names = list(dict.fromkeys(measurement.recording for measurement in measurements))
    first = measurements[0]
    return record_of(
        names, (first.cutoff, first.band), region_of(channels_of(measurements)), residual_stddev, standard_errors
    )


def record_of(
    bags: Sequence[str],
    filters: tuple[float, float],
    region: Mapping[str, Sequence[float]],
    residual_stddev: float,
    standard_errors: Mapping[str, float],
) -> dict[str, object]:
    """The same from the recordings' names, the filters' cutoff and band (Hz), and the region of validity."""
    return {
        "bags": list(bags),
        "date": datetime.now(UTC).date().isoformat(),
        "cutoff": float(filters[0]),
        "band": float(filters[1]),
        "residual_stddev": float(f"{residual_stddev:.6g}"),
        "region": {name: list(ends) for name, ends in region.items()},
        "standard_errors": {
            name: float(f"{error:.6g}") for name, error in standard_errors.items() if np.isfinite(error)
        },
    }


def region_of(channels: Channels) -> dict[str, list[float]]:
    """Lowest and highest value of each channel that was there, less the outermost thousandth on either side."""
    values = {name: channels(row) for name, row in REGION_ROWS.items()}
    return {name: own.percentiles(REGION) for name, own in values.items() if own.size}
