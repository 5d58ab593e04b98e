"""Time of one live sample: the model alone, and the whole line from stamp to estimate, for one damper and for four in
one call; compiled and in plain Python."""

import os
import subprocess
import sys
import time

import numpy as np

from damper_estimator.compiled import COMPILED
from damper_estimator.model import load_model
from damper_estimator.runtime import Line, deployed
from damper_estimator.signals.layout import DT, ROWS, A, V, X

MODELS = ("carrera_akutain", "bouc_wen", "lozoya_santos_complete")
SAMPLES, ROUNDS = 4000, 5


def model_time(name: str) -> float:
    """Median over rounds of the time per sample of the model alone, us."""
    stream = load_model(name).stream()
    blocks = np.full((SAMPLES, ROWS, 1), np.nan)
    phase = np.arange(SAMPLES) * 0.01
    blocks[:, X, 0], blocks[:, V, 0] = 0.02 * np.sin(phase), 0.2 * np.cos(phase)
    blocks[:, A, 0], blocks[:, DT, 0] = -2.0 * np.sin(phase), 0.001
    blocks[0, DT, 0] = 0.0
    return timed(lambda i: stream.force(blocks[i]))


def line_time(name: str, dampers: int) -> float:
    """The same for the whole line of so many dampers: admission, filter, model, status."""
    line, model = Line(), deployed(load_model(name), 60.0, 0.1)
    for number in range(dampers):
        line.add(str(number), model)
    displacement = np.repeat(0.02 * np.sin(np.arange(SAMPLES) * 0.01)[:, None], dampers, axis=1)
    present, counter = np.ones(dampers, bool), iter(range(10**9))
    return timed(lambda i: line.step(next(counter) * 1_000_000, displacement[i], present))


def timed(step) -> float:
    """Median over rounds of the mean time of ``step(i)``, us."""
    step(0)
    rounds = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for i in range(SAMPLES):
            step(i)
        rounds.append((time.perf_counter() - start) / SAMPLES * 1e6)
    return float(np.median(rounds))


def main() -> None:
    """Prints a row per model; the plain-Python rows come from a separate process."""
    kind = "numba" if COMPILED else "plain Python"
    for name in MODELS:
        print(
            f"{name:24s} {kind:13s} model {model_time(name):7.2f} us   whole line {line_time(name, 1):7.2f} us, "
            f"four dampers {line_time(name, 4):7.2f} us",
            flush=True,
        )
    if COMPILED:
        subprocess.run([sys.executable, __file__], env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, check=True)


if __name__ == "__main__":
    main()
