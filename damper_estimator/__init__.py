"""Damper force estimation in real time, and diagnosis of wrong estimates.

    import damper_estimator as de

    recording = de.read("drive.mcap")
    model = de.fit(recording, "carrera_akutain").model
    result = de.compare(recording, model)
    found = de.diagnose(recording, model)

Everything is in SI units; displacement is positive in extension, force positive where it resists extension. Results
are displayed in notebooks and have ``figure()``, ``to_dict()``, ``to_dataframe()`` and ``save(path)``. With several
dampers a result is a mapping by name. Unusable input raises ``InputError`` with a one-line text. The names below
are imported when they are used; docs/python.md is a tour.
"""

from typing import TYPE_CHECKING

from damper_estimator.lazy import lazy_names

if TYPE_CHECKING:
    from damper_estimator.errors import InputError
    from damper_estimator.model import DamperModel, library_models, load_model, save_model
    from damper_estimator.signals import SignalMap, load_signal_map, save_signal_map
    from damper_estimator.workflows import (
        ComparisonResults,
        DiagnosisResults,
        FitResults,
        ImprovementResults,
        PlanResults,
        Recording,
        ReplayResults,
        compare,
        diagnose,
        fit,
        improve,
        plan,
        read,
        replay,
        to_c,
        to_fmu,
    )

__version__ = "0.1.0"
__all__ = [
    "ComparisonResults",
    "DamperModel",
    "DiagnosisResults",
    "FitResults",
    "ImprovementResults",
    "InputError",
    "PlanResults",
    "Recording",
    "ReplayResults",
    "SignalMap",
    "compare",
    "diagnose",
    "fit",
    "improve",
    "library_models",
    "load_model",
    "load_signal_map",
    "plan",
    "read",
    "replay",
    "save_model",
    "save_signal_map",
    "to_c",
    "to_fmu",
]
__getattr__, __dir__ = lazy_names(__name__, __file__)
