"""What a fit leaves in the model file: where it comes from, how well it agrees, where it is valid."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

import numpy as np

from damper_estimator.model.estimator import REGION_ROWS
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
    return {
        "bags": list(dict.fromkeys(measurement.recording for measurement in measurements)),
        "date": datetime.now(UTC).date().isoformat(),
        "cutoff": float(measurements[0].cutoff),
        "band": float(measurements[0].band),
        "residual_stddev": float(f"{residual_stddev:.6g}"),
        "region": region(measurements),
        "standard_errors": {
            name: float(f"{error:.6g}") for name, error in standard_errors.items() if np.isfinite(error)
        },
    }


def region(measurements: Sequence[Measurement]) -> dict[str, list[float]]:
    """Lowest and highest value of each channel that was there, less the outermost thousandth on either side."""
    ranges = {}
    for name, row in REGION_ROWS.items():
        values = np.concatenate([m.kinematics.block[row, m.judged] for m in measurements])
        values = values[np.isfinite(values)]
        if values.size:
            ranges[name] = [float(value) for value in np.percentile(values, REGION)]
    return ranges
