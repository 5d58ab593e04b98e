"""The steps of a model on a page: what was done to it, back and forth."""

from dataclasses import dataclass

from damper_estimator.diagnosis import Step
from damper_estimator.signals import DamperSignals


@dataclass(frozen=True)
class Version:
    """The model after a step, with the damper's entry of the signal map that belongs to it."""

    step: Step
    signals: DamperSignals


@dataclass(frozen=True)
class History:
    """Versions up to the newest, and which of them is on view.

    Attributes:
        versions: the first is the model as given.
        at: index of the one on view; those behind it were undone.
    """

    versions: tuple[Version, ...]
    at: int = 0

    @property
    def now(self) -> Version:
        """The version on view."""
        return self.versions[self.at]

    @property
    def done(self) -> tuple[Version, ...]:
        """The versions up to the one on view."""
        return self.versions[: self.at + 1]

    def then(self, version: Version) -> "History":
        """One step further; what was undone is forgotten. A parameter moved again by hand is the same step."""
        before = self.done
        if self.at and version.step.action == "set" == self.now.step.action and _same(version, self.now):
            before = before[:-1]
        return History((*before, version), len(before))

    def instead(self, version: Version) -> "History":
        """The version on view replaced; what was undone stays."""
        return History((*self.versions[: self.at], version, *self.versions[self.at + 1 :]), self.at)

    def undone(self) -> "History":
        """One step back, where there is one."""
        return History(self.versions, max(self.at - 1, 0))

    def redone(self) -> "History":
        """One step forth, where there is one."""
        return History(self.versions, min(self.at + 1, len(self.versions) - 1))


def _same(one: Version, other: Version) -> bool:
    return one.step.effect == other.step.effect
