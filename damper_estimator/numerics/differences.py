"""One-sided finite differences: direction and size of the step."""

import numpy as np

SMOOTH = 1e-5
"""Step over a parameter's size where the force is smooth; far above the tolerance of implicit solutions."""

ROUGH = 2e-3
"""The same where the force jumps from sample to sample: voids and stops begin and end on samples."""


def stepped(
    vector: np.ndarray, position: int, size: float, lower: float, upper: float, share: float = SMOOTH
) -> tuple[np.ndarray, float]:
    """A vector (n,) with one entry moved by ``share`` of ``size``, and the actual size of the step after rounding.

    The step goes up; it goes down where it would pass ``upper``, and is shortened to the distance of the farther
    bound where both are too near.
    """
    value = vector[position]
    above, below = upper - value, value - lower
    step = share * size
    if step > above:
        step = -min(step, below) if below > above else above
    changed = vector.copy()
    changed[position] += step
    return changed, float(changed[position] - value)
