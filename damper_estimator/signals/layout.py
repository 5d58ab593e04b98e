"""Rows of the sample block, the only part of the signals that effects use.

A block is a contiguous float64 array of shape (8, n), SI units, displacement positive in extension. Row ``DT`` is the
step that led to the sample; 0 marks the first sample after a reset. An absent row is NaN.
"""

T = 0  # s since the first sample
DT = 1  # s since the sample before; 0 at a start
X = 2  # m, displacement
V = 3  # m/s, velocity
A = 4  # m/s^2, acceleration
STROKE = A  # m, in series effects only, whose X and V are their deflection: displacement of the damper
COMMAND = 5  # A (or V, or 1) of a semi-active damper
TEMPERATURE = 6  # deg C
PRESSURE = 7  # Pa
ROWS = 8
