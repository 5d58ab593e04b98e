"""Formats numbers for text."""

import numpy as np

UNDETERMINED = "undetermined"


def number(value: float, digits: int = 3) -> str:
    """``digits`` significant digits, without an exponent if large; a dash if not finite."""
    if not np.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text


def plus_minus(value: float, error: float, text: str | None = None) -> str:
    """A standard error as text; a value that it exceeds, or of which none is known, is undetermined.

    Args:
        text: of the error; two significant digits without it.
    """
    if not np.isfinite(error):
        return UNDETERMINED
    shown = f"± {number(error, 2) if text is None else text}"
    return f"{shown}, {UNDETERMINED}" if error > abs(value) else shown
