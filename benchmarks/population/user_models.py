"""A user's data: recordings, a signal map, and a model made by the verbs on the recording without the effect."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import damper_estimator as de
from damper_estimator.model import DamperModel, parse_model
from damper_estimator.signals import default_signals
from population.measurement_chain import Chain, Samples
from population.strength_search import rms

DAMPER = "damper"
FITTED = ("viscous_curve", "carrera_akutain", "dahl", "lugre", "bouc_wen", "his_non_hysteresis")
IMPROVED = ("linear_viscous", "viscous_curve", "carrera_akutain", "dahl", "coulomb")
MAGNETIC = ("semi_active_yield", "bouc_wen", "kwok")
GOOD_ENOUGH = 0.7
"""Of the hidden rms change: a model with a larger error on the recording without it needs other effects first, and the
user improves it beforehand.
"""


def signal_map(chain: Chain) -> de.SignalMap:
    """The user's map: default topics, and the stated spring if the gauge carries one."""
    damper = replace(default_signals(DAMPER), spring_rate=chain.spring, preload=chain.preload)
    return de.SignalMap(dampers={DAMPER: damper})


def recording(several: Sequence[Samples], signals: de.SignalMap) -> de.Recording:
    """The recordings as the product reads them, pooled."""
    each = [
        de.Recording.from_arrays(
            samples.time, samples.x, force=samples.force, temperature=samples.temperature, command=samples.current,
            damper=DAMPER, name=samples.name, signals=signals,
        )
        for samples in several
    ]  # fmt: skip
    sources = tuple(source for recording in each for source in recording.sources)
    measurements = {DAMPER: tuple(one for recording in each for one in recording.measurements[DAMPER])}
    return replace(each[0], sources=sources, measurements=measurements)


def error(model: DamperModel, measured: de.Recording) -> float:
    """rms in N as ``compare`` prints it."""
    return de.compare(measured, model).rmse_n


def hand_made(base: de.Recording, hidden: Sequence[str], rng: np.random.Generator) -> DamperModel:
    """A careful engineer's chain: a curve, gas, friction, an acceleration term or a lag; without hidden effects."""
    measurement = base.measurements[DAMPER][0]
    low, high = np.quantile(measurement.kinematics.velocity[measurement.judged], [0.001, 0.999])
    speeds = np.array([0.01, 0.03, 0.06, 0.11, 0.18, 0.28, 0.42, 0.6, 0.85, 1.2])
    knots = [low, *-speeds[speeds < -0.85 * low][::-1], 0.0, *speeds[speeds < 0.85 * high], high]
    chain: list[dict[str, object]] = [
        {"viscous_curve": {"velocity": [float(v) for v in knots], "force": [0.0] * len(knots)}}
    ]
    if "gas_spring" not in hidden:
        chain.append({"gas_spring": {}})
    if not {"friction", "hysteresis"} & set(hidden):
        chain.append({"dahl": {}})
    lags = {"valve_delay", "oil_compressibility", "mount_compliance", "channel_skew", "inertia"}
    if not lags & set(hidden):
        chain.append({"force_lag": {"time_constant": 3e-4}} if rng.random() < 0.5 else {"acceleration_hysteresis": {}})
    return parse_model({"name": "hand_made", "source": "the user's", "effects": chain}, "hand_made")


def drawn_way(rng: np.random.Generator, family: str, moving_current: bool) -> tuple[str, str]:
    """Verb and start model."""
    if moving_current:
        return ("improve", str(rng.choice(MAGNETIC[:2])))
    draw = rng.random()
    if draw < 0.3:
        return "fit", "hand_made"
    if draw < 0.65:
        names = FITTED if family != "magneto" else (*FITTED, *MAGNETIC[1:])
        return "fit", str(rng.choice(names))
    return "improve", str(rng.choice(IMPROVED))


def made(
    way: tuple[str, str], base: de.Recording, twin: de.Recording, start: DamperModel, hidden_rms: float
) -> tuple[DamperModel, str]:
    """The user's model, and its origin.

    A fitted model whose error without the effect exceeds the hidden change goes through ``improve`` too; if that is not
    enough, the hand-made chain is tried, and the user has the better of both.

    Args:
        twin: another recording without the effect.
        start: the hand-made chain before identification.
    """
    verb, name = way
    given = start if name == "hand_made" else name

    def off(model: DamperModel) -> float:
        return max(error(model, base), error(model, twin))

    if verb == "fit":
        fitted = de.fit(base, given).model
        if off(fitted) <= GOOD_ENOUGH * hidden_rms:
            return fitted, f"fit {name}"
        improved, how = de.improve(base, fitted).model, f"fit and improve {name}"
    else:
        improved, how = de.improve(base, given).model, f"improve {name}"
    if off(improved) <= GOOD_ENOUGH * hidden_rms:
        return improved, how
    by_hand = de.fit(base, start).model
    return (by_hand, "fit hand_made") if off(by_hand) < off(improved) else (improved, how)


def load(path: Path) -> DamperModel:
    """A saved model."""
    return de.load_model(str(path))


__all__ = ["DAMPER", "error", "load", "made", "recording", "rms", "signal_map"]
