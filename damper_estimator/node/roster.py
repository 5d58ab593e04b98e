"""The dampers that the node estimates, and their models: determined before the first message, or refused."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import load_model
from damper_estimator.node.displacement import Estimator
from damper_estimator.node.settings import Settings
from damper_estimator.node.wire import ForcesTemplate
from damper_estimator.runtime import Deployed, Line, deployed
from damper_estimator.signals import DamperSignals, SignalMap, default_signals, delay_seconds, load_signal_map

MOST_DAMPERS = 64  # that arrive by name: a publisher of ever new names must not fill the memory


@dataclass(frozen=True, eq=False)
class Roster:
    """The dampers of the settings.

    Attributes:
        signal_map: with the cutoff in use.
        known: the dampers that are named in advance, in order.
        template: model of every damper that arrives by name, if none is named in advance; else None.
    """

    signal_map: SignalMap
    known: tuple[Estimator, ...]
    template: Deployed | None

    def newcomer(self, name: str) -> Estimator:
        """A damper that arrives by name; only with a template."""
        return Estimator(name, default_signals(name), self.template)

    @property
    def delay(self) -> float:
        """Delay of the estimates behind the damper, s: that of the filter less the predicted time; none with an
        accelerometer.
        """
        if self.signal_map.fusion is not None:
            return 0.0
        lead = self.template.lead if self.template else self.known[0].deployed.lead
        return delay_seconds(self.signal_map.cutoff) - lead


def make_roster(settings: Settings) -> Roster:
    """The roster of the settings; every model is loaded, checked and compiled.

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
        raise InputError(f"{settings.model}: contains no model; give a folder with one DAMPER.yaml each")
    names = settings.dampers or tuple(signal_map.dampers) or tuple(folder)

    def prepared(damper: str | None, signals: DamperSignals | None = None) -> Deployed:
        lead = settings.compensation * delay_seconds(signal_map.cutoff)
        model = load_model(settings.model, damper)
        unit = deployed(model, signal_map.cutoff, settings.max_gap, lead, signal_map.fusion, signals)
        _warm_up(unit)
        return unit

    if not names:
        return Roster(signal_map, (), prepared(None))
    signals = {name: signal_map.dampers.get(name) or default_signals(name) for name in names}
    known = (Estimator(name, channels, prepared(name, channels)) for name, channels in signals.items())
    return Roster(signal_map, tuple(known), None)


def _warm_up(unit: Deployed) -> None:
    """Compiles the kernels of a model now, so that the first message does not wait for it."""
    line = Line()
    line.add("", unit)
    for millisecond in range(2):
        line.step(millisecond * 1_000_000, np.zeros(1), np.ones(1, bool))
    ForcesTemplate([""], "").message(0, line.output.numbers[0], line.output.status[0], np.ones(1, bool))
