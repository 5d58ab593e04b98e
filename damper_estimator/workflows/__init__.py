"""Use cases as functions: read, compare, fit, diagnose, improve, plan, replay, characterize, tare, inspect, export.

Command line, studio, fleet and the public Python API call these functions, and not each other. The functions return
frozen results by damper, raise ``InputError`` for unusable input and print nothing. Names are imported when they are
used, so that a verb loads only the libraries that it needs.
"""

from typing import TYPE_CHECKING

from damper_estimator.lazy import lazy_names

if TYPE_CHECKING:
    from damper_estimator.codegen import WrittenC, WrittenFmu
    from damper_estimator.planning import library_rigs
    from damper_estimator.workflows.bench_import import (
        Guessed,
        Imported,
        guess_files,
        import_files,
        import_guessed,
    )
    from damper_estimator.workflows.cases import Case, DiagnosisCases, diagnosis_cases, no_progress
    from damper_estimator.workflows.characterization import (
        CharacterizationResults,
        DamperCharacterized,
        characterize,
        characterize_case,
        structure_of,
    )
    from damper_estimator.workflows.comparing import (
        ComparisonResults,
        ModelsCompared,
        compare,
        comparison_request,
        page_title,
    )
    from damper_estimator.workflows.diagnosis import DiagnosisResults, diagnose, diagnose_case
    from damper_estimator.workflows.exporting import to_c, to_fmu
    from damper_estimator.workflows.fitting import (
        FitOptions,
        FitResults,
        fit,
        fit_record,
        fit_with,
        output_paths,
        save_fit,
    )
    from damper_estimator.workflows.improvement import (
        ImprovementResults,
        improve,
        improve_case,
        improvement_record,
    )
    from damper_estimator.workflows.inspection import DamperInspected, Inspection, inspect
    from damper_estimator.workflows.joint_fitting import CHANNELS, JointlyFitted, fit_jointly
    from damper_estimator.workflows.model_arguments import ModelLike, model_for, models_for
    from damper_estimator.workflows.planning import RIG, PlanResults, Tie, plan, plan_case, ties_of
    from damper_estimator.workflows.reading import Reader, open_reader, read, signal_map_of
    from damper_estimator.workflows.recording import Recording, in_words, no_force_error
    from damper_estimator.workflows.replay_files import ReplayOptions, ReplaySetup, replay_bag, replay_to
    from damper_estimator.workflows.replay_line import ReplayCounts
    from damper_estimator.workflows.replaying import ReplayResults, replay
    from damper_estimator.workflows.riding import RIDE_DAMPERS, RIDE_LAWS, DamperRide, RideResults, ride
    from damper_estimator.workflows.simulated_bags import write_record, write_signal_map, write_truth
    from damper_estimator.workflows.taring import Tare, tare

__all__ = [
    "CHANNELS",
    "RIDE_DAMPERS",
    "RIDE_LAWS",
    "RIG",
    "Case",
    "CharacterizationResults",
    "ComparisonResults",
    "DamperCharacterized",
    "DamperInspected",
    "DamperRide",
    "DiagnosisCases",
    "DiagnosisResults",
    "FitOptions",
    "FitResults",
    "Guessed",
    "Imported",
    "ImprovementResults",
    "Inspection",
    "JointlyFitted",
    "ModelLike",
    "ModelsCompared",
    "PlanResults",
    "Reader",
    "Recording",
    "ReplayCounts",
    "ReplayOptions",
    "ReplayResults",
    "ReplaySetup",
    "RideResults",
    "Tare",
    "Tie",
    "WrittenC",
    "WrittenFmu",
    "characterize",
    "characterize_case",
    "compare",
    "comparison_request",
    "diagnose",
    "diagnose_case",
    "diagnosis_cases",
    "fit",
    "fit_jointly",
    "fit_record",
    "fit_with",
    "guess_files",
    "import_files",
    "import_guessed",
    "improve",
    "improve_case",
    "improvement_record",
    "in_words",
    "inspect",
    "library_rigs",
    "model_for",
    "models_for",
    "no_force_error",
    "no_progress",
    "open_reader",
    "output_paths",
    "page_title",
    "plan",
    "plan_case",
    "read",
    "replay",
    "replay_bag",
    "replay_to",
    "ride",
    "save_fit",
    "signal_map_of",
    "structure_of",
    "tare",
    "ties_of",
    "to_c",
    "to_fmu",
    "write_record",
    "write_signal_map",
    "write_truth",
]
__getattr__, __dir__ = lazy_names(__name__, __file__)
