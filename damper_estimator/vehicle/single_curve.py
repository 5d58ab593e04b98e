"""The single curve of a damper: force over velocity alone, measured on any model like on a damper on a test bench.

Sines of one frequency and rising amplitude; the forces at the largest rebound and compression speed are points of the
curve. It excludes memory, and gas and spring forces away from the middle position. Source: Gao et al., section 3.1.1.
"""

import numpy as np

from damper_estimator.model import DamperModel, parse_model
from damper_estimator.signals.layout import DT, ROWS, A, T, V, X

SPEEDS = (0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3, 0.4, 0.55, 0.7, 0.9, 1.2)
"""m/s, peaks of the sines."""

FREQUENCY = 1.5
"""Hz."""

LARGEST = 0.05
"""m, largest amplitude; beyond it the frequency rises instead."""

_CYCLES, _PER_CYCLE = 3, 2000


def single_curve(model: DamperModel) -> DamperModel:
    """A model of only the curve, ``viscous_curve``; straight between its points."""
    points = [_peaks(model, speed) for speed in SPEEDS]
    rest = float(model.force(_sine(0.0, FREQUENCY))[-1])
    velocity = [*(-speed for speed in reversed(SPEEDS)), 0.0, *SPEEDS]
    force = [*(low for low, _ in reversed(points)), rest, *(high for _, high in points)]
    content = {
        "name": f"single curve of {model.name}",
        "source": f"peaks of sines of {FREQUENCY:g} Hz, taken from {model.name}",
        "effects": [{"viscous_curve": {"velocity": velocity, "force": force}}],
    }
    return parse_model(content, f"single curve of {model.name}")


def _peaks(model: DamperModel, speed: float) -> tuple[float, float]:
    """Force in N at the largest speed of compression and of rebound, in the last cycle."""
    frequency = max(FREQUENCY, speed / (2.0 * np.pi * LARGEST))
    block = _sine(speed / (2.0 * np.pi * frequency), frequency)
    force = model.force(block)[-_PER_CYCLE:]
    velocity = block[V, -_PER_CYCLE:]
    return float(force[np.argmin(velocity)]), float(force[np.argmax(velocity)])


def _sine(amplitude: float, frequency: float) -> np.ndarray:
    """Cycles of a sine as a block (8, n), without command and slow channels."""
    step = 1.0 / (frequency * _PER_CYCLE)
    time = step * np.arange(_CYCLES * _PER_CYCLE + 1)
    omega = 2.0 * np.pi * frequency
    block = np.full((ROWS, time.size), np.nan)
    block[T], block[DT] = time, step
    block[DT, 0] = 0.0
    block[X] = amplitude * np.sin(omega * time)
    block[V] = amplitude * omega * np.cos(omega * time)
    block[A] = -amplitude * omega**2 * np.sin(omega * time)
    return block
