"""Damper models: lists of effects, their YAML files, and the streams that run them."""

from damper_estimator.model.ahead import compile_loops_ahead, wait_for_loops
from damper_estimator.model.damper_model import DamperModel, Slot
from damper_estimator.model.element import Element, make_element
from damper_estimator.model.model_files import library_models, load_model, parse_model, save_model
from damper_estimator.model.stream import Stream

__all__ = [
    "DamperModel",
    "Element",
    "Slot",
    "Stream",
    "compile_loops_ahead",
    "library_models",
    "load_model",
    "make_element",
    "parse_model",
    "save_model",
    "wait_for_loops",
]
