"""From stamps to samples: signal maps, the filter that differentiates, and measurements ready for comparison."""

from damper_estimator.signals.admission import DEFAULT_MAX_GAP, Counts
from damper_estimator.signals.butterworth import delay_seconds, low_pass, low_pass_zero_phase
from damper_estimator.signals.fusion import Fusion
from damper_estimator.signals.kinematics import Differentiator, Kinematics
from damper_estimator.signals.map_writing import save_signal_map, signal_map_yaml
from damper_estimator.signals.measurement import Measurement, measure
from damper_estimator.signals.signal_map import (
    Channel,
    DamperSignals,
    SignalMap,
    default_signals,
    load_signal_map,
    parse_signal_map,
)

__all__ = [
    "DEFAULT_MAX_GAP",
    "Channel",
    "Counts",
    "DamperSignals",
    "Differentiator",
    "Fusion",
    "Kinematics",
    "Measurement",
    "SignalMap",
    "default_signals",
    "delay_seconds",
    "load_signal_map",
    "low_pass",
    "low_pass_zero_phase",
    "measure",
    "parse_signal_map",
    "save_signal_map",
    "signal_map_yaml",
]
