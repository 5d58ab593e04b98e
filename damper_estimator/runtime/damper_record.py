"""Settings and running state of one damper on a line, as one record of a structured array.

A record costs a call into compiled code as much as one array, however many fields it has, and its fields have names.
"""

import numpy as np

from damper_estimator.signals.admission import NON_FINITE
from damper_estimator.signals.butterworth import STATE_SIZE
from damper_estimator.signals.fusion import FUSION_SIZE, NOISES
from damper_estimator.signals.layout import COMMAND, PRESSURE, ROWS, TEMPERATURE, A, V, X
from damper_estimator.signals.possible import STATE_SIZE as POSSIBLE_SIZE

GOOD, WARMING_UP, EXTRAPOLATING, DEGRADED, STALE = range(5)
SLOW = ("command", "temperature", "pressure")  # the rows of the block from COMMAND on
# Rows of the block by the name under which a fit records its region of validity.
REGION_ROWS = {
    "displacement": X, "velocity": V, "acceleration": A,
    "command": COMMAND, "temperature": TEMPERATURE, "pressure": PRESSURE,
}  # fmt: skip

# Counts: the verdicts (0 to 6) of ``signals.admission``; faults of the displacement and the model, doubtful samples,
# samples while the displacement was constant in spite of its noise; implausible values of the slow channels, samples
# for which one was silent, and samples before its first value, by row; then one per status.
JUMPS, LATE, NOT_FINITE, SUSPECT, STUCK = range(NON_FINITE + 1, NON_FINITE + 6)
IMPLAUSIBLE = STUCK + 1
SILENT = IMPLAUSIBLE + len(SLOW)
UNKNOWN = SILENT + len(SLOW)
BY_STATUS = UNKNOWN + len(SLOW)
COUNTS = BY_STATUS + STALE + 1

RECORD = np.dtype(
    [
        # The program: rows of the table of operations, states, registers, whether it has series operations.
        ("first_row", "i8"),
        ("last_row", "i8"),
        ("first_state", "i8"),
        ("last_state", "i8"),
        ("motions", "i8"),
        ("forces", "i8"),
        ("series", "i8"),
        # Settings.
        ("max_gap", "i8"),  # ns
        ("cutoff", "f8"),  # Hz, 0: unfiltered
        ("noise_cutoff", "f8"),  # Hz of the filter through which the displacement's noise reaches the velocity
        ("lead", "f8"),  # s
        ("settling", "i8"),  # ns after a start or a fault until filter and model have forgotten it
        ("stddev", "f8"),  # N
        ("fuses", "i8"),  # whether an accelerometer is fused
        ("noises", "f8", (NOISES,)),
        ("bounds", "f8", (ROWS, 2)),  # region of the fit, infinite if it has none
        ("identified", "i8"),
        # Settings of the slow channels.
        ("low", "f8", (len(SLOW),)),  # values beyond are implausible
        ("high", "f8", (len(SLOW),)),
        ("max_age", "f8", (len(SLOW),)),  # s
        ("adaptive", "i8", (len(SLOW),)),  # whether several usual intervals without a message are too old already
        ("matters", "i8", (len(SLOW),)),  # whether the model's force depends on the channel
        ("memory", "i8", (len(SLOW),)),  # ns for which the force remembers a wrong value
        # State of admission, filter and fusion.
        ("begun", "i8"),
        ("origin", "i8"),  # ns, first stamp
        ("admission", "i8", (2,)),
        ("possible", "f8", (POSSIBLE_SIZE,)),
        ("filter", "f8", (STATE_SIZE,)),
        ("fused", "f8", (FUSION_SIZE,)),
        # State of the accelerometer: its last stamp in ns, and its usual interval in ns.
        ("felt_last", "i8"),
        ("felt_interval", "f8"),
        # State of the slow channels: last plausible value, number of messages, stamp of the first sample after the
        # last of them, usual interval in s, whether the last message had an implausible value.
        ("held", "f8", (len(SLOW),)),
        ("heard", "i8", (len(SLOW),)),
        ("since", "i8", (len(SLOW),)),
        ("interval", "f8", (len(SLOW),)),
        ("wrong", "i8", (len(SLOW),)),
        # State of the status, ns: last accepted stamp, start, last fault; degraded and outside the region until;
        # outside that of the command until.
        ("last", "i8"),
        ("started", "i8"),
        ("fault", "i8"),
        ("degraded_until", "i8"),
        ("outside_until", "i8"),
        ("command_outside_until", "i8"),
        # Typical step and the number of steps it was learned from, last raw value and its differences, how many of them
        # are known, variance of the noise.
        ("step", "f8"),
        ("steps", "f8"),
        ("raw", "f8"),
        ("first", "f8"),
        ("second", "f8"),
        ("known", "f8"),
        ("variance", "f8"),
        # The smallest change; the number of remembered small changes, the share of zigzags and of equal neighbours
        # among them; likelihood of the present run of equal values; the last finite force.
        ("smallest", "f8"),
        ("small", "f8"),
        ("zigzag", "f8"),
        ("equal", "f8"),
        ("likelihood", "f8"),
        ("given", "f8"),
        ("counts", "i8", (COUNTS,)),
    ],
    align=True,
)


def fresh_record() -> np.ndarray:
    """(1,) of ``RECORD``: a damper before its first sample, settings at zero."""
    record = np.zeros(1, RECORD)
    record["held"] = np.nan
    return record
