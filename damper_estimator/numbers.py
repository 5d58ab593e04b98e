"""Numbers as people read them."""

import numpy as np


def number(value: float, digits: int = 3) -> str:
    """So many digits, without an exponent where it is large, or a dash where it is not known."""
    if not np.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text
