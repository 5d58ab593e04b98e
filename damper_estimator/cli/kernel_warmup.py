"""Compiles in advance the kernels that the verbs and the node use, so that their first start is quick."""

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import monotonic

import numpy as np

from damper_estimator.signals.layout import DT, ROWS, T, X

SECONDS, STEP = 4.0, 0.002
_WITH_SERIES, _WITHOUT = "mr_damper_on_mount", "viscous_curve"


def compile_kernels() -> float:
    """Compiles all kernels on all cores and stores the machine code; returns the duration in s.

    Each process compiles different kernels; a second run only loads them.
    """
    from damper_estimator.effects.discovery import all_effects
    from damper_estimator.model import library_models

    begun = monotonic()
    models = list(library_models())
    effects = [name for name, effect in all_effects().items() if effect.kernel is not None]
    count = max(1, (os.cpu_count() or 1) - 1)
    with ProcessPoolExecutor(count + 1, mp_context=get_context("spawn")) as pool:
        work = [pool.submit(_chain)]
        work += [pool.submit(_kernels, effects[i::count], models[i::count]) for i in range(count)]
        for future in work:
            future.result()
    # These depend on the chain; two processes must not store variants of one function at the same time.
    _verbs()
    _line()
    return monotonic() - begun


def _chain() -> None:
    """The loop over a model's effects, without and with a series element; takes longest."""
    for name in (_WITHOUT, _WITH_SERIES):
        _run(name)


def _verbs() -> None:
    """The kernels for reading, filtering and judging a recording."""
    from damper_estimator.share import share_path
    from damper_estimator.workflows import compare, read

    compare(read([share_path("bags") / "hidden_unseen.mcap"], stop=SECONDS), _WITHOUT)


def _kernels(effects: Sequence[str], models: Sequence[str]) -> None:
    """The kernels of these effects, and the preparation of these models."""
    from damper_estimator.effects.discovery import all_effects
    from damper_estimator.model import load_model
    from damper_estimator.model.program import function_list

    function_list([all_effects()[name].kernel for name in effects], False)
    for name in models:
        _ = load_model(name).program


def _line() -> None:
    """The kernels of replay and the node."""
    from damper_estimator.model import load_model
    from damper_estimator.runtime import Line, deployed
    from damper_estimator.workflows import Recording, replay

    time = np.arange(0.0, SECONDS, STEP)
    model = load_model(_WITHOUT)
    replay(Recording.from_arrays(time, 0.01 * np.sin(10.0 * time), damper="warm"), model)
    line = Line()
    line.add("warm", deployed(model, 60.0, 0.1))
    line.step(0, np.zeros(1), np.ones(1, bool))


def _run(name: str) -> None:
    from damper_estimator.model import Stream, load_model

    block = np.zeros((ROWS, 8))
    block[T], block[DT], block[X] = STEP * np.arange(8), STEP, 1e-3
    stream = Stream(load_model(name).program)
    stream.force(block)
    stream.contributions(block)
