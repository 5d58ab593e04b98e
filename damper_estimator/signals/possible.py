"""Keeps displacements that no suspension can reach out of filter and model.

A model that remembers for long (heat, a void) would be wrong for minutes after a single sample of some metres, long
after filter and status have recovered. A displacement is impossible if it moves faster than ``FASTEST`` from the last
possible one, which is then used in its place. Where the damper has moved on meanwhile, ``STEADY`` samples have to
follow each other within reach of it. A displacement that stays beyond (another zero, another unit) is a new start after
``LONGEST``, as after a gap: nothing is locked out. For live estimates and their repetition; the analysis of recordings
knows what follows, and leaves out whatever comes back (``signals.spikes``).
"""

from damper_estimator.compiled import compiled
from damper_estimator.signals.admission import DUPLICATE, START

FASTEST = 10.0  # m/s, of a wheel that hits the ground after a fall of 5 m
SMALL = 0.001  # m, smaller changes are noise or resolution
STROKE = 0.1  # m, within which the damper can have moved while its samples were impossible
LONGEST = 0.1  # s
STEADY = 3.0  # samples that follow each other, which values at random rarely do
STATE_SIZE = 4  # last possible value, m; s since then; value of the sample before, m; samples that follow each other


@compiled
def keep_possible(value, verdict, dt, state, used):
    """Replaces the impossible values of a block of samples; a block of one is the live case.

    Args:
        value: (n,) m, as received; ``verdict``: (n,) int64 and ``dt``: (n,) s, from ``admission.judge``; both are
            changed where the displacement starts at another place.
        state: (4,) kept from block to block.
        used: (n,) m output, for filter and model; undefined if the sample was dropped.
    """
    for i in range(value.size):
        if verdict[i] >= DUPLICATE:
            continue
        if dt[i] > 0.0:
            reach = max(SMALL, FASTEST * dt[i])
            state[1] += dt[i]
            state[3] = state[3] + 1.0 if abs(value[i] - state[2]) <= reach else 0.0
            moved = abs(value[i] - state[0])
            if moved > reach and (state[3] < STEADY or moved > min(STROKE, FASTEST * state[1])):
                if state[3] < STEADY or state[1] <= LONGEST:
                    used[i], state[2] = state[0], value[i]
                    continue
                verdict[i], dt[i] = START, 0.0
        used[i] = state[0] = state[2] = value[i]
        state[1] = 0.0
