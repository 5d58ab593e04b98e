"""Arrays as plotly's scripts read them."""

import base64
from collections.abc import Mapping

import numpy as np


def packed(values: np.ndarray, kind: str = "f4") -> dict[str, str]:
    """An array in plotly's form for typed arrays: ``f4``, ``f8`` or ``u1``, little endian, base64."""
    raw = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
    return {"dtype": kind, "bdata": base64.b64encode(raw).decode("ascii")}


def unpacked(column: Mapping[str, str]) -> np.ndarray:
    """The array that ``packed`` was called with, in the precision of its kind."""
    return np.frombuffer(base64.b64decode(column["bdata"]), dtype=f"<{column['dtype']}")
