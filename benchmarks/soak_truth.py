"""The true force: the plant's, through the judge's own filter; and the models' forces for undisturbed inputs.

The filter is the estimator's by definition (third-order Butterworth, linear between samples), computed with scipy's
matrix exponential, so that its delay does not count as an error. The undisturbed estimate is that of the same model on
the same sensors without faults: its error is the model's, not that of a fault.
"""

from pathlib import Path

import numpy as np
from scipy.linalg import expm
from scipy.signal import butter, tf2ss
from soak_plant import NAMES, Sample

from damper_estimator.model import load_model
from damper_estimator.runtime import FIELDS, Line, deployed
from damper_estimator.signals import load_signal_map


class Filter:
    """H(s) of a third-order Butterworth low-pass over k signals that are linear between samples; final."""

    def __init__(self, cutoff: float, step: float, first: np.ndarray) -> None:
        """``cutoff`` in Hz, ``step`` in s, ``first`` (k,), its settled start."""
        a, b, self._c, _ = tf2ss(*butter(3, 2.0 * np.pi * cutoff, analog=True))
        # State, input and its slope as one linear system without input: exact for a ramp.
        whole = np.zeros((5, 5))
        whole[:3, :3], whole[:3, 3:4], whole[3, 4] = a, b, 1.0
        moved = expm(whole * step)
        self._state, self._input, self._slope = moved[:3, :3], moved[:3, 3:4], moved[:3, 4:5] / step
        self._x = -np.linalg.solve(a, b) @ first[None, :]
        self._last = first

    def take(self, values: np.ndarray) -> np.ndarray:
        """Filters the next (k,) values."""
        self._x = self._state @ self._x + self._input * self._last + self._slope * (values - self._last)
        self._last = values
        return (self._c @ self._x)[0]


class Undisturbed:
    """The estimate of every damper on undisturbed inputs; final."""

    def __init__(self, models: Path, signals: Path) -> None:
        signal_map = load_signal_map(signals)
        self.is_fused = signal_map.fusion is not None
        self._line = Line()
        for name in NAMES:
            model = load_model(models / f"{name}.yaml")
            model = deployed(model, signal_map.cutoff, 0.1, fusion=signal_map.fusion, signals=signal_map.dampers[name])
            self._line.add(name, model)
        self.heeds_temperature = [record["matters"][1] != 0 for record in self._line.records]
        self.stddev = np.array([record["stddev"] for record in self._line.records])

    def take(self, stamp: int, displacement: list[float], current: list[float], samples: list[Sample],
             felt: list[float]) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Processes the sensors at one moment; returns forces (4,) in N and status (4,)."""
        arrived = self._line.input
        for k, sample in enumerate(samples):
            arrived.slow[0, 0, k], arrived.slow[0, 1, k] = current[k], sample.temperature
            arrived.received[0, :2, k] += 1
            arrived.acceleration[0, k], arrived.acceleration_stamp[0, k] = felt[k], stamp
        self._line.step(stamp, np.array(displacement), np.ones(len(NAMES), bool))
        answered = self._line.output
        return answered.numbers[0, FIELDS.index("force")].copy(), answered.status[0].copy()
