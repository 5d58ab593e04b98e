"""Python and NumPy operations without a C function, in the restricted Python that is translated with the kernels.

Floats are compared like in Python's ``min`` and ``max``: the first stays unless the other is smaller or larger.
"""

import numpy as np


def smaller(one, other):
    """min(one, other)."""
    return other if other < one else one


def larger(one, other):
    """max(one, other)."""
    return other if other > one else one


def magnitude(number):
    """The absolute value of an integer."""
    return -number if number < 0 else number


def squared(number):
    """number ** 2."""
    return number * number


def floor_rest(number, divisor):
    """number % divisor for a positive divisor: never negative."""
    rest = c_rest(number, divisor)
    return rest + divisor if rest < 0 else rest


def floor_divided(number, divisor):
    """number // divisor for a positive divisor: rounded down."""
    quotient = c_quotient(number, divisor)
    return quotient - 1 if c_rest(number, divisor) < 0 else quotient


def c_rest(number, divisor):
    """The rest of a division that rounds towards zero; written as C's operator."""
    return int(np.fmod(number, divisor))


def c_quotient(number, divisor):
    """A division that rounds towards zero; written as C's operator."""
    return int(number / divisor)


def place_right(knots, value):
    """np.searchsorted(knots, value, side="right"): number of knots that are not above the value; NaN is above all."""
    low, high = 0, knots.size
    while low < high:
        middle = (low + high) // 2
        if value < knots[middle]:
            high = middle
        else:
            low = middle + 1
    return low


def interpolated(value, knots, values):
    """np.interp(value, knots, values) for one value and finite, rising knots; constant beyond them."""
    last = knots.size - 1
    if np.isnan(value):
        return value
    if value < knots[0]:
        return values[0]
    if value >= knots[last]:
        return values[last]
    k = place_right(knots, value) - 1
    if knots[k] == value:
        return values[k]
    slope = (values[k + 1] - values[k]) / (knots[k + 1] - knots[k])
    return slope * (value - knots[k]) + values[k]
