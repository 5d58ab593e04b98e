"""How a coil's current becomes effect: the magnetisation that saturates, as a curve taken from a force table.

Models take the effect as straight in the command. With the curve in the command's channel (``table`` of the signal map,
raw current and value) they are right over the whole range; the command that an inverse answers is turned back here.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.control.table import CurrentTable

SLIDING = (0.1, 0.7)
"""m/s, speeds at which a table tells the yield force: well past the change of sign, below what is seldom driven."""


@dataclass(frozen=True)
class CoilCurve:
    """Currents (k,) in A and their effects (k,), both rising from 0; the last ones are equal."""

    current: np.ndarray
    effect: np.ndarray

    def effect_of(self, current: float) -> float:
        """What takes the current's place in the model."""
        return float(np.interp(current, self.current, self.effect))

    def current_for(self, effect: float) -> float:
        """A, whose effect this is."""
        return float(np.interp(effect, self.effect, self.current))


def coil_curve(table: CurrentTable) -> CoilCurve:
    """The curve behind a table whose currents begin at 0: mean change of the force against that without current.

    Raises:
        ValueError: where more current does not mean more force.
    """
    speed = np.abs(table.velocity)
    sliding = (speed >= SLIDING[0]) & (speed <= SLIDING[1])
    change = np.sign(table.velocity)[:, None] * (table.force - table.force[:, :1])
    effect = change[sliding].mean(axis=0)
    if np.any(np.diff(effect) <= 0.0):
        raise ValueError(f"forces change by {np.round(effect)} N over {table.current} A; more current must mean more")
    return CoilCurve(table.current, effect / effect[-1] * table.current[-1])
