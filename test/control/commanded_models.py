"""Motions, and models whose force depends on a command in various ways."""

from functools import cache

import numpy as np

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, Element, library_models, load_model, make_element
from damper_estimator.signals.layout import DT, ROWS, A, T, V, X

STEP = 0.002
LOWEST, HIGHEST = 0.0, 2.0
LIBRARY = sorted(
    name
    for name, path in library_models().items()
    if any(word in path.read_text(encoding="utf-8") for word in ("command_", "semi_active"))
)


def smooth_motion(size: int, seed: int, speed: float = 0.3, step: float = STEP) -> np.ndarray:
    """A block (8, size) of smooth random motion with ``speed`` m/s rms, its first sample a start, no slow channels."""
    random = np.random.default_rng(seed)
    time = step * np.arange(size)
    omega = 2.0 * np.pi * random.uniform(0.5, 12.0, (6, 1))
    angle = omega * time + random.uniform(0.0, 2.0 * np.pi, (6, 1))
    weight = speed * np.sqrt(2.0 / 6.0)
    block = np.full((ROWS, size), np.nan)
    block[T], block[DT] = time, step
    block[DT, 0] = 0.0
    block[X] = np.sum(weight / omega * np.sin(angle), axis=0)
    block[V] = np.sum(weight * np.cos(angle), axis=0)
    block[A] = np.sum(-weight * omega * np.sin(angle), axis=0)
    return block


def random_commands(size: int, seed: int) -> np.ndarray:
    """Commands (size,) with occasional steps."""
    random = np.random.default_rng([seed, 3])
    levels = random.uniform(LOWEST, HIGHEST, size // 20 + 1)
    return np.repeat(levels, 20)[:size]


def entry(name: str, path: tuple[Element, ...] = (), **values: object) -> Element:
    return make_element(find_effect(name), values, path)


def model_of(*entries: Element) -> DamperModel:
    return DamperModel("made", "test", entries)


@cache
def commanded_models() -> dict[str, DamperModel]:
    """Models of the library, and some others."""
    viscous = entry("viscous", rate=800.0)
    squash = entry("semi_active_squash", gain=600.0, damping=30.0)
    others = {
        "without a lag": model_of(viscous, squash),
        "steep at once": model_of(viscous, entry("semi_active_squash", gain=600.0, damping=5000.0)),
        "against the spring": model_of(viscous, entry("semi_active_squash", gain=600.0, damping=8.0, stiffness=40.0)),
        "behind a lag of the force": model_of(entry("command_lag"), viscous, squash, entry("force_lag")),
        "parallel to friction with memory": model_of(entry("command_lag"), entry("bouc_wen"), squash),
        "in series with oil": model_of(entry("command_lag"), entry("oil_spring", (viscous, squash))),
        "on a mount, without a lag": model_of(entry("rubber_mount", (viscous, squash)), entry("gas_spring")),
        "with a dead band": model_of(
            entry("command_lag"), entry("command_scale", gain=-0.2, offset=0.3), viscous, squash
        ),
        "with a leak behind the oil": model_of(
            entry("oil_spring", (entry("one_way_leak", share=0.6), viscous, squash)), entry("direction_gain", gain=0.3)
        ),
        "asymmetric": model_of(
            viscous, entry("path", (squash, entry("direction_gate", direction=-1.0))), entry("coulomb")
        ),
    }  # fmt: skip
    return {name: load_model(name) for name in LIBRARY} | others
