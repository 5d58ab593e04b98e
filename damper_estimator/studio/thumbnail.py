"""Small pictures of curves and clouds as the addresses of images; a page shows dozens of them at no cost."""

from collections.abc import Sequence
from urllib.parse import quote

import numpy as np

from damper_estimator.numbers import number
from damper_estimator.report.theme import COLOURS, LIGHT

_POINTS, _WIDTH, _HEIGHT = 400, 108, 64


def picture(x: np.ndarray, y: np.ndarray) -> str:
    """A small drawing of a curve through (n,), (n,) with its axes."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if len(x) < 2:
        return ""
    few = np.linspace(0, len(x) - 1, min(_POINTS, len(x))).astype(int)
    px, py = _places(x[few], y[few], _reach(x), _reach(y))
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(px, py, strict=True))
    colour = COLOURS[LIGHT]["model0"]
    return _drawing(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1"/>')


def dots_picture(clouds: Sequence[tuple[np.ndarray, np.ndarray, str]]) -> str:
    """Clouds of dots at velocities (n,) in m/s and forces (n,) in N, in a colour each, on axes that they share."""
    wide, high = (max(_reach(cloud[axis]) for cloud in clouds) for axis in (0, 1))
    parts = []
    for x, y, colour in clouds:
        px, py = _places(x, y, wide, high)
        path = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(px, py, strict=True) if np.isfinite(a) and np.isfinite(b))
        parts.append(f'<path d="{path}" stroke="{colour}" stroke-width="1.1" stroke-linecap="round" opacity=".7"/>')
    ends = f'<text x="{_WIDTH - 1}" y="{_HEIGHT / 2 + 6}" text-anchor="end">{wide:.2g} m/s</text>'
    ends += f'<text x="{_WIDTH / 2 + 2}" y="5">{number(high)} N</text>'
    return _drawing("".join(parts) + f'<g font-size="5" font-family="sans-serif" fill="#777">{ends}</g>')


def _reach(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return max(float(np.max(np.abs(known))), 1e-9) if known.size else 1.0


def _places(x: np.ndarray, y: np.ndarray, wide: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    return _WIDTH / 2 * (1.0 + 0.95 * x / wide), _HEIGHT / 2 * (1.0 - 0.95 * y / high)


def _drawing(content: str) -> str:
    axes = f"M0 {_HEIGHT / 2}H{_WIDTH}M{_WIDTH / 2} 0V{_HEIGHT}"
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}"><path d="{axes}" stroke="#999" '
        f'stroke-width=".6"/>{content}</svg>'
    )
    return f"data:image/svg+xml,{quote(svg)}"
