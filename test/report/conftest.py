"""A diagnosis as the engine makes it, of a viscous damper whose seal began to rub; others are made from it."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis import Diagnosis, Improvement, Step, diagnose
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.signals import Counts, Measurement, default_signals
from damper_estimator.signals.kinematics import Differentiator

VISCOUS = DamperModel(
    "viscous", "", (make_element(find_effect("linear_viscous"), {"rebound": 1500.0, "compression": 1500.0}),)
)
FRICTION = 60.0


def friction(kinematics):
    return FRICTION * np.tanh(kinematics.velocity / 0.004)


def measurement(seed, extra=friction, seconds=8.0, rate=250.0, damper="front_left"):
    """Random motion, the force of ``VISCOUS`` and what ``extra`` adds."""
    time = np.arange(round(seconds * rate)) / rate
    draw = np.random.default_rng(seed)
    x = 0.004 * sum(np.sin(2 * np.pi * f * time + draw.uniform(0, 6)) / f for f in np.linspace(0.5, 9.0, 10))
    stamp = np.round(time * 1e9).astype(np.int64)
    kinematics, verdict = Differentiator(60.0, 0.1).block(stamp, x + 2e-6 * draw.standard_normal(time.size))
    force = 1500.0 * kinematics.velocity + extra(kinematics) + 2.0 * draw.standard_normal(time.size)
    return Measurement(
        f"/data/{seed}.mcap",
        damper,
        kinematics,
        force,
        kinematics.warm(),
        Counts.of(verdict),
        force,
        x,
        60.0,
        30.0,
        default_signals(damper),
    )


@pytest.fixture(scope="session")
def found() -> Diagnosis:
    """What the engine says of the damper that rubs."""
    return diagnose(replace(VISCOUS, fit={"residual_stddev": 2.0}), [measurement(1)], [measurement(2)])


@pytest.fixture(scope="session")
def measured():
    """Makes measurements; see ``measurement``."""
    return measurement


@pytest.fixture(scope="session")
def nothing_found(found) -> Diagnosis:
    """A diagnosis of the improved model that finds nothing."""
    ranking = tuple(replace(row, reason=row.reason or "explains nothing on unseen data") for row in found.ranking)
    last = found.findings[-1].rmse_after_n
    return replace(
        found,
        model=found.improved,
        verdict="nothing_missing",
        sentence="Nothing is missing that these data could show.",
        findings=(),
        elements=(),
        ranking=ranking,
        rmse_n=last,
    )


@pytest.fixture(scope="session")
def improved(found, nothing_found) -> Improvement:
    """A start, an effect added, another that was needless taken out."""
    finding = found.findings[0]
    start = Step("start", None, None, found.model, found.rmse_n, found.rmse_n, None, "the model as given")
    after = finding.rmse_after_n
    add = Step("add", finding.effect, finding.phenomenon, found.improved, after + 0.5, after, found, "")
    prune = replace(add, action="prune", effect="bouc_wen", phenomenon=None, diagnosis=None, note="needless")
    last = nothing_found
    return Improvement(
        steps=(start, add, prune),
        verdict=last.verdict,
        sentence="added friction",
        noise_floor_n=found.noise_floor_n,
        model=found.improved,
        signals=found.signals,
        rejected=last.ranking,
        fit=found.fit,
        unseen=found.unseen,
        final=last,
        first=found,
    )
