"""From stamps to samples: signal maps, the differentiating filter, and measurements for comparison with models."""

from damper_estimator.signals.admission import DEFAULT_MAX_GAP, DUPLICATE, Counts
from damper_estimator.signals.butterworth import columns_zero_phase, delay_seconds, low_pass, low_pass_zero_phase
from damper_estimator.signals.channels import ChannelData, find_topic, read_channels, signals_for
from damper_estimator.signals.element_path import named_element
from damper_estimator.signals.fusion import Fusion
from damper_estimator.signals.kinematics import Differentiator, Kinematics
from damper_estimator.signals.map_writing import save_signal_map, signal_map_yaml
from damper_estimator.signals.measurement import Measurement, check_force, measure, measured
from damper_estimator.signals.part_channels import part_channels
from damper_estimator.signals.rest import LEAST_SECONDS, Rest, find_rests
from damper_estimator.signals.signal_map import (
    Channel,
    DamperSignals,
    SignalMap,
    default_signals,
    load_signal_map,
    parse_signal_map,
)
from damper_estimator.signals.spikes import displacement_course, force_course, usual_range

__all__ = [
    "DEFAULT_MAX_GAP",
    "DUPLICATE",
    "LEAST_SECONDS",
    "Channel",
    "ChannelData",
    "Counts",
    "DamperSignals",
    "Differentiator",
    "Fusion",
    "Kinematics",
    "Measurement",
    "Rest",
    "SignalMap",
    "check_force",
    "columns_zero_phase",
    "default_signals",
    "delay_seconds",
    "displacement_course",
    "find_rests",
    "find_topic",
    "force_course",
    "load_signal_map",
    "low_pass",
    "low_pass_zero_phase",
    "measure",
    "measured",
    "named_element",
    "parse_signal_map",
    "part_channels",
    "read_channels",
    "save_signal_map",
    "signal_map_yaml",
    "signals_for",
    "usual_range",
]
