"""The result of a plan."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from damper_estimator.planning.criterion import Chances
from damper_estimator.planning.limits import Limits
from damper_estimator.planning.rig import Rig
from damper_estimator.planning.steps import Step

SURE = 0.95  # probability of a right decision at which a test is long enough
LIKELY = 0.5  # probability of a right decision from which on a test separates
HOPELESS = 0.05  # below it, for every phenomenon as the truth, no test can
REST = 2.0, 1.0  # s, before and after the drive, so that the gauge can be tared


@dataclass(frozen=True)
class Curve:
    """Probabilities over the length of a test, (n,) each: minutes, right, wrong."""

    minutes: np.ndarray
    right: np.ndarray
    wrong: np.ndarray

    def until(self, last: int) -> "Curve":
        """Its first ``last`` points."""
        return Curve(self.minutes[:last], self.right[:last], self.wrong[:last])


@dataclass(frozen=True)
class Sharpened:
    """A parameter with its standard error on the old recordings, and expected with the test."""

    address: str
    value: float
    before: float
    after: float


@dataclass(frozen=True)
class Plan:
    """A test, and what is expected of it.

    Attributes:
        phenomena, effects: hypotheses; empty where parameters are sharpened.
        sentence: the result in one sentence.
        rig, limits: where and within what it is driven.
        steps: in the order in which they are driven.
        chances: of the whole test; None where parameters are sharpened.
        curve: over its length, in the order of choice.
        shortest: minutes for ``SURE``; None where no test within the limits reaches it.
        would: what else would separate, in words.
        parameters: sharpened ones.
        untestable: effects that the recordings cannot show, why, and what would show them.
        displacement: (n,) m at ``limits.rate``, the whole drive.
        time, force, velocity: of the step that shows the difference best: (n,) s, (h, n) N, (n,) m/s.
        band_n: two standard deviations of noise and form on that step, N.
        clearest: that step, in words.
    """

    phenomena: tuple[str, ...]
    effects: tuple[str, ...]
    sentence: str
    rig: Rig
    limits: Limits
    steps: tuple[Step, ...]
    chances: Chances | None
    curve: Curve
    shortest: float | None
    would: tuple[str, ...]
    parameters: tuple[Sharpened, ...]
    untestable: tuple[tuple[str, str, str], ...]
    displacement: np.ndarray
    time: np.ndarray
    force: np.ndarray
    velocity: np.ndarray
    band_n: float
    clearest: str

    @property
    def minutes(self) -> float:
        """Length of the drive."""
        return self.displacement.size / self.limits.rate / 60.0

    @property
    def listed(self) -> list[tuple[Step, str]]:
        """The steps in words, equal ones in a row as one: the step, and how it is driven."""
        groups = [list(group) for _, group in groupby(self.steps, key=lambda step: step.words)]
        return [(one[0], f"{len(one)} times: {one[0].words}" if len(one) > 1 else one[0].words) for one in groups]

    @property
    def rest_samples(self) -> int:
        """Samples of rest before the first step."""
        return round(REST[0] * self.limits.rate)

    @property
    def separates(self) -> bool:
        """Whether the test is more likely to break the tie than not."""
        return self.chances is None or self.chances.best >= LIKELY

    @property
    def may_separate(self) -> bool:
        """Whether the test may break the tie."""
        return self.chances is None or self.chances.best >= HOPELESS

    def record(self) -> dict[str, object]:
        """For JSON and for the plan's file."""
        record: dict[str, object] = {
            "sentence": self.sentence,
            "rig": self.rig.name,
            "hypotheses": [{"phenomenon": p, "effect": e} for p, e in zip(self.phenomena, self.effects, strict=True)],
            "minutes": round(self.minutes, 3),
            "limits": self.limits.record(),
            "steps": [step.record() for step in self.steps],
        }
        if self.chances is not None:
            record["predicted"] = {
                "right": round(self.chances.right, 4),
                "wrong": round(self.chances.wrong, 4),
                "stays_tied": round(self.chances.tied, 4),
                "if_it_is": {
                    name: {"right": round(right, 4), "wrong": round(wrong, 4)}
                    for name, right, wrong in self.chances.by_truth
                },
                "evidence_nats_per_minute": round(self.chances.evidence / max(self.minutes, 1e-9), 4),
                "shortest_minutes_for_95_percent": None if self.shortest is None else round(self.shortest, 3),
            }
        if self.parameters:
            record["parameters"] = [
                {"name": estimate.address, "value": estimate.value, "standard_error_now": estimate.before,
                 "standard_error_after": estimate.after} for estimate in self.parameters
            ]  # fmt: skip
        record["what_would"] = list(self.would)
        record["not_testable_before"] = [
            {"effect": effect, "because": reason, "drive": drive} for effect, reason, drive in self.untestable
        ]
        return record


def sentence_of(phenomena: Sequence[str], chances: Chances, minutes: float, shortest: float | None) -> str:
    """The result of a plan that tells phenomena apart, in one sentence."""
    names = " and ".join(name.replace("_", " ") for name in dict.fromkeys(phenomena))
    odds = (
        f"{100.0 * chances.right:.0f} % probability of a right decision, {100.0 * chances.wrong:.1f} % of a wrong one"
    )
    if chances.best < HOPELESS:
        return f"No drive within these limits can tell {names} apart: {minutes:.1f} minutes give {odds}."
    if chances.best < LIKELY:
        return (
            f"{names.capitalize()} will probably stay tied within these limits: the best test ({minutes:.1f} minutes) "
            f"gives {odds}."
        )
    if shortest is None:
        each = [f"{100.0 * right:.0f} % if it is {name.replace('_', ' ')}" for name, right, _ in chances.by_truth]
        each_right = ", ".join(each)
        return f"{minutes:.1f} minutes tell {names} apart, with {odds} (right: {each_right}); 95 % is not reached."
    return f"{minutes:.1f} minutes tell {names} apart, with {odds}; {shortest:.1f} minutes are enough for 95 %."
