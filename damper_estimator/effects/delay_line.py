"""A ring buffer of past samples for the delay effects; not an effect itself.

The state holds the clock, the count, the newest position, and pairs (time, value). The next sample replaces one that
follows its predecessor by less than ``SPACING``, so that the ring covers the longest delay at any rate. The clock and
the stored times are set back every second, so that times stay exact over long runs, also in single precision
(``codegen``).
"""

from damper_estimator.compiled import compiled

CAPACITY = 256
SPACING = 0.0008  # s: 256 samples then hold at least MAX_DELAY
MAX_DELAY = 0.2  # s
_LAP = 1.0  # s
_CLOCK, _COUNT, _NEWEST, _PAIRS = range(4)
STATES = _PAIRS + 2 * CAPACITY


@compiled
def delayed(state, dt, value, delay):
    """Stores ``value`` and returns the value of ``delay`` seconds ago, linear between samples.

    Until the line is filled it returns the first value; ``dt`` <= 0 empties the line.
    """
    if dt <= 0.0:
        state[_CLOCK] = state[_COUNT] = state[_NEWEST] = 0.0
    else:
        if state[_CLOCK] > _LAP:
            _set_back(state)
        state[_CLOCK] += dt
    _put(state, value)
    wanted = state[_CLOCK] - delay
    newest, count = int(state[_NEWEST]), int(state[_COUNT])
    late_time, late_value = state[_CLOCK], value
    for k in range(count):
        slot = _PAIRS + 2 * ((newest - k) % CAPACITY)
        time, past = state[slot], state[slot + 1]
        if time <= wanted:
            share = (wanted - time) / (late_time - time) if late_time > time else 0.0
            return past + share * (late_value - past)
        late_time, late_value = time, past
    return late_value


@compiled
def _set_back(state):
    """The same times, counted from now."""
    for k in range(CAPACITY):
        state[_PAIRS + 2 * k] -= state[_CLOCK]
    state[_CLOCK] = 0.0


@compiled
def _put(state, value):
    """Appends a sample, or replaces the newest one if that is too close to its predecessor."""
    newest, count = int(state[_NEWEST]), int(state[_COUNT])
    head = _PAIRS + 2 * newest
    before = _PAIRS + 2 * ((newest - 1) % CAPACITY)
    crowded = count > 1 and state[head] - state[before] < SPACING
    if count > 0 and not crowded:
        newest = (newest + 1) % CAPACITY
        head = _PAIRS + 2 * newest
    if not crowded:
        state[_COUNT] = float(min(count + 1, CAPACITY))
    state[_NEWEST] = float(newest)
    state[head], state[head + 1] = state[_CLOCK], value
