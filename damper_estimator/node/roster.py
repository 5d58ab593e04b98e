"""Which dampers the node estimates, and with what: decided before the first message, completely or not at all."""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, load_model
from damper_estimator.node.live_damper import LiveDamper, warm_up
from damper_estimator.node.settings import Settings
from damper_estimator.signals import SignalMap, default_signals, load_signal_map

MOST_DAMPERS = 64  # of those that nobody named: a publisher of ever new names must not fill the memory


@dataclass(frozen=True)
class Roster:
    """What the settings say about dampers.

    Attributes:
        names: known beforehand; empty where every name that arrives is taken.
        signal_map: with the cutoff that is in use.
        model: file, folder or name.
        max_gap: s.
    """

    names: tuple[str, ...]
    signal_map: SignalMap
    model: str
    max_gap: float

    @property
    def is_open(self) -> bool:
        """Whether dampers are taken as their names arrive."""
        return not self.names

    def damper(self, name: str) -> LiveDamper:
        """A damper ready to estimate.

        Raises:
            InputError: where its model is unusable.
        """
        signals = self.signal_map.dampers.get(name) or default_signals(name)
        model = _loaded(self.model, None if self.is_open else name)
        return LiveDamper(name, signals, model, self.signal_map.cutoff, self.max_gap)

    def check(self) -> None:
        """Loads and compiles every model that will be needed.

        Raises:
            InputError: where one is unusable.
        """
        for name in self.names or ("",):
            model = self.damper(name).model
            warm_up(model, self.signal_map.cutoff, self.max_gap)


@cache
def _loaded(model: str, damper: str | None) -> DamperModel:
    return load_model(model, damper)


def make_roster(settings: Settings) -> Roster:
    """The roster that the settings describe, checked.

    Raises:
        InputError: one line; an unusable signal map or model, or a damper that the map does not have.
    """
    signal_map = load_signal_map(settings.signals or None)
    if settings.cutoff >= 0.0:
        signal_map = replace(signal_map, cutoff=settings.cutoff)
    unknown = [name for name in settings.dampers if signal_map.dampers and name not in signal_map.dampers]
    if unknown:
        raise InputError(
            f"parameter dampers: {', '.join(unknown)} not in {signal_map.where}, which has "
            f"{', '.join(signal_map.dampers)}"
        )
    folder = sorted(path.stem for path in Path(settings.model).glob("*.yaml")) if Path(settings.model).is_dir() else []
    if not folder and Path(settings.model).is_dir():
        raise InputError(f"{settings.model}: holds no model; give a folder with one DAMPER.yaml each")
    names = settings.dampers or tuple(signal_map.dampers) or tuple(folder)
    roster = Roster(names, signal_map, settings.model, settings.max_gap)
    roster.check()
    return roster
