"""Characteristic diagrams of a damper: mean loops, points A to H, pattern types, and a matching model structure."""

from damper_estimator.characterization.characteristics import BANDS, Band, Characterization, Diagram, characterize
from damper_estimator.characterization.loops import Loop, mean_loops
from damper_estimator.characterization.model_structure import Structure, derive, structure_model
from damper_estimator.characterization.patterns import Pattern, classify
from damper_estimator.characterization.points import MEANINGS, Line, Point, characteristic_points
from damper_estimator.characterization.quasi_static import QuasiStatic, quasi_static
from damper_estimator.characterization.serialization import peaks, peaks_csv, record
from damper_estimator.characterization.subtraction import Difference, difference, semi_active

__all__ = [
    "BANDS",
    "MEANINGS",
    "Band",
    "Characterization",
    "Diagram",
    "Difference",
    "Line",
    "Loop",
    "Pattern",
    "Point",
    "QuasiStatic",
    "Structure",
    "characteristic_points",
    "characterize",
    "classify",
    "derive",
    "difference",
    "mean_loops",
    "peaks",
    "peaks_csv",
    "quasi_static",
    "record",
    "semi_active",
    "structure_model",
]
