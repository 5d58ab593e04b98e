"""Runs the Python line on the inputs of generated C; inputs from recordings and with all kinds of faults; random
models."""

from pathlib import Path

import numpy as np

from damper_estimator.codegen.c_source import Damper
from damper_estimator.codegen.compiled_damper import inputs
from damper_estimator.effects.discovery import all_effects, find_effect
from damper_estimator.model import DamperModel, make_element
from damper_estimator.recordings import open_bag
from damper_estimator.runtime import DamperEstimator, LineInput, LineOutput
from damper_estimator.runtime.damper_record import SLOW
from damper_estimator.signals import load_signal_map
from damper_estimator.signals.channels import find_topic, signals_for


def python_line(damper: Damper, given: np.ndarray) -> LineOutput:
    """Inputs (n,) of ``one_sample.INPUT`` through the line."""
    arrived = LineInput.empty(given.size, 1)
    arrived.stamp[:], arrived.displacement[:, 0], arrived.suspect[:] = (
        given["stamp"], given["displacement"], given["suspect"][:, None],
    )  # fmt: skip
    for row, role in enumerate(SLOW):
        came = given[f"{role}_arrived"] != 0
        arrived.slow[:, row, 0], arrived.received[:, row, 0] = last_come(given[role], came), np.cumsum(came)
    felt = given["acceleration_arrived"] != 0
    arrived.acceleration[:, 0] = last_come(given["acceleration"], felt)
    arrived.acceleration_stamp[:, 0] = last_come(given["acceleration_stamp"], felt, 0)
    return DamperEstimator(damper.deployed).line.run(arrived)


def last_come(values: np.ndarray, came: np.ndarray, before=np.nan) -> np.ndarray:
    """The last received value at each of n samples."""
    index = np.maximum.accumulate(np.where(came, np.arange(values.size), -1))
    return np.where(index >= 0, values[index], before)


def recorded(path: Path, damper: str) -> np.ndarray:
    """Inputs from a recording: every displacement, with the slow channels received since the previous one."""
    with open_bag(path) as bag:
        signals = signals_for(bag, load_signal_map(None), damper).dampers[damper]
        columns = {}
        for role in ("displacement", *SLOW):
            channel = getattr(signals, role)
            if (topic := find_topic(bag, channel.topic)) is not None:
                columns[role] = bag.columns(topic, (channel.field,))
    motion = columns.pop("displacement")
    given = inputs(motion.stamp, signals.displacement.value(motion.values[:, 0]))
    for role, slow in columns.items():
        last = np.searchsorted(slow.rank, motion.rank) - 1
        given[role] = getattr(signals, role).value(np.where(last >= 0, slow.values[last, 0], np.nan))
        given[f"{role}_arrived"] = np.diff(last, prepend=-1) > 0
    return given


def random_model(seed: int) -> DamperModel:
    """A random chain of effects, nested in paths and behind compliances, with values inside their bounds."""
    random = np.random.default_rng([7, seed])
    effects = {name: effect for name, effect in all_effects().items() if effect.kind != "channel"}

    def entries(depth: int) -> tuple:
        chosen = []
        for _ in range(random.integers(1, 4)):
            kinds = ["source"] * 4 + ["modifier", "input"] + ["path", "series"] * (depth > 0)
            kind = random.choice(kinds)
            if kind == "path":
                chosen.append(make_element(find_effect("path"), {}, entries(depth - 1)))
                continue
            effect = effects[random.choice([name for name, e in effects.items() if e.kind == kind])]
            chosen.append(make_element(effect, values(effect), entries(depth - 1) if kind == "series" else ()))
        return tuple(chosen)

    def values(effect) -> dict:
        sizes = {s.name: s.default for s in effect.settings}
        return {
            p.name: float(np.clip(p.default * random.uniform(0.5, 1.5), p.lower, p.upper))
            for p in effect.parameters if p.size is None
        } | {
            p.name: [float(v) for v in np.clip(random.uniform(-500.0, 500.0, p.length(sizes)), p.lower, p.upper)]
            for p in effect.parameters if p.size is not None
        }  # fmt: skip

    return DamperModel("random", "test", (make_element(find_effect("linear_viscous")), *entries(2)))


def rough(seed: int, size: int, mean_step: float = 2e-3, trouble: float = 1.0) -> np.ndarray:
    """Inputs with all faults of a vehicle: uneven stamps, gaps, reversed or repeated stamps, steps of the clock,
    non-finite values and jumps, silent or impossible slow channels, doubtful senders; ``trouble`` times as often."""
    random = np.random.default_rng(seed)
    steps = (random.uniform(0.2, 1.8, size) * mean_step * 1e9).astype(np.int64)
    odd = random.random(size) / max(trouble, 1e-9)
    steps[odd < 0.004] = 250_000_000  # gaps
    steps[(odd > 0.004) & (odd < 0.012)] = 0
    steps[(odd > 0.012) & (odd < 0.02)] *= -1
    steps[(odd > 0.02) & (odd < 0.022)] = -3_000_000_000  # the clock is set back
    steps[(odd > 0.03) & (odd < 0.06)] *= 5  # late
    stamp = 1_700_000_000_000_000_000 + np.cumsum(steps)
    time = np.arange(size) * mean_step
    x = 0.03 * np.sin(2.0 * np.pi * (0.5 + 3.0 * random.random()) * time) + 0.01 * np.sin(2.0 * np.pi * 11.0 * time)
    x += random.normal(0.0, 1e-6, size)
    x[random.random(size) < 0.003 * trouble] += 0.05
    for wrong in (np.nan, np.inf, -np.inf, 1e300, 9e5):
        x[random.random(size) < 0.0012 * trouble] = wrong
    quiet = np.sin(0.9 * time) > 0.9
    channels = {}
    for name, low, high, rate in (
        ("command", 0.0, 1.5, 0.2),
        ("temperature", 20.0, 90.0, 0.02),
        ("pressure", 1e5, 2e6, 0.05),
    ):
        values = low + (high - low) * (0.5 + 0.5 * np.sin(time + random.random()))
        values[random.random(size) < 0.002 * trouble] = 1e9
        values[(random.random(size) > rate) | quiet] = np.nan
        channels[name] = values
    given = inputs(stamp, x, **channels)
    for name in ("command", "temperature", "pressure"):  # a non-finite message is a message
        given[f"{name}_arrived"][random.random(size) < 0.001] = 1
    given["acceleration"] = random.normal(0.0, 20.0, size)
    given["acceleration_arrived"] = random.random(size) < 0.8
    given["acceleration_stamp"] = stamp
    given["suspect"] = random.random(size) < 0.002 * trouble
    return given
