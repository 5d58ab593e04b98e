"""Measurements made with a model itself: random motion, its force, and noise on it."""

from collections.abc import Callable

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, Element, make_element
from damper_estimator.signals import Counts, Measurement, default_signals
from damper_estimator.signals.kinematics import differentiate_recording

RATE = 250.0  # Hz
CUTOFF, BAND = 60.0, 30.0


def random_motion(seconds: float, seed: int, rms: float) -> tuple[np.ndarray, np.ndarray]:
    """Stamps (ns) and displacement (m) with content from 0.1 to 15 Hz."""
    random = np.random.default_rng(seed)
    size = int(seconds * RATE)
    frequency = np.fft.rfftfreq(size, 1.0 / RATE)
    shape = np.where((frequency > 0.1) & (frequency < 15.0), np.maximum(frequency, 0.3) ** -1.2, 0.0)
    x = np.fft.irfft(shape * np.exp(2j * np.pi * random.uniform(size=frequency.size)), size)
    return np.round(np.arange(size) / RATE * 1e9).astype(np.int64), x * rms / x.std()


def measurement_of(
    model: DamperModel,
    seed: int = 0,
    seconds: float = 16.0,
    rms: float = 0.01,
    noise: float = 0.01,
    scale: float = 1.0,
    command: float | np.ndarray = np.nan,
) -> Measurement:
    """What would have been measured on a damper that is the model; ``noise`` is a share of the force's deviation."""
    stamp, x = random_motion(seconds, seed, rms)
    kinematics, _ = differentiate_recording(stamp, x, CUTOFF, 0.1, command=np.broadcast_to(command, x.shape))
    clean = scale * model.force(kinematics.block)
    force = clean + noise * np.nanstd(clean) * np.random.default_rng(1000 + seed).standard_normal(clean.size)
    return Measurement(
        recording=f"recording_{seed}",
        damper="damper",
        kinematics=kinematics,
        force=force,
        judged=kinematics.warm(),
        counts=Counts(samples=x.size),
        gauge=force,
        raw_displacement=x,
        cutoff=CUTOFF,
        band=BAND,
        signals=default_signals("damper"),
    )


def make_entry(name: str, path: tuple[Element, ...] = (), **values: object) -> Element:
    return make_element(find_effect(name), values, path)


def make_model(*entries: Element, fixed: tuple[str, ...] = ()) -> DamperModel:
    return DamperModel("made", "test", entries, fixed)


@pytest.fixture(scope="session")
def measured() -> Callable[..., Measurement]:
    return measurement_of


@pytest.fixture(scope="session")
def entry() -> Callable[..., Element]:
    return make_entry


@pytest.fixture(scope="session")
def model_of() -> Callable[..., DamperModel]:
    return make_model
