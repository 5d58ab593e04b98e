"""Formats numbers for text."""

import numpy as np


def number(value: float, digits: int = 3) -> str:
    """``digits`` significant digits, without an exponent if large; a dash if not finite."""
    if not np.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text
