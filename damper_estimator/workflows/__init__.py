"""Use cases as functions: read, compare, fit, diagnose, improve, plan, replay, characterize, tare, inspect, export.

Command line, studio, fleet and the public Python API are faces of these functions; none of them uses another one.
What is here returns frozen results by damper and raises ``InputError`` for unusable input; it prints nothing. Names are
imported when they are used, so that a verb loads only the libraries that it needs.
"""

from typing import TYPE_CHECKING

from damper_estimator.lazy import lazy_names

if TYPE_CHECKING:
    from damper_estimator.codegen import WrittenC, WrittenFmu
    from damper_estimator.workflows.characterization import (
        CharacterizationResults,
        DamperCharacterized,
        characterize,
        structure_of,
    )
    from damper_estimator.workflows.comparison import (
        ComparisonResults,
        ModelsCompared,
        asked,
        compare,
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
    from damper_estimator.workflows.importing import (
        Guessed,
        Imported,
        guess_files,
        import_files,
        import_guessed,
    )
    from damper_estimator.workflows.improvement import (
        ImprovementResults,
        improve,
        improve_case,
        improvement_record,
    )
    from damper_estimator.workflows.inspection import DamperInspected, Inspection, inspect
    from damper_estimator.workflows.joint_fitting import CHANNELS, JointlyFitted, fit_jointly
    from damper_estimator.workflows.judging import Case, Judging, judging_of
    from damper_estimator.workflows.models import ModelLike, model_for, models_for
    from damper_estimator.workflows.planning import RIG, PlanResults, plan
    from damper_estimator.workflows.reading import Reader, opened, read, signal_map_of
    from damper_estimator.workflows.recording import Recording, in_words, no_force
    from damper_estimator.workflows.replay_files import ReplayOptions, ReplaySetup, replay_bag, replay_to
    from damper_estimator.workflows.replay_line import Tally
    from damper_estimator.workflows.replaying import ReplayResults, replay
    from damper_estimator.workflows.taring import Tare, tare

__all__ = [
    "CHANNELS",
    "RIG",
    "Case",
    "CharacterizationResults",
    "ComparisonResults",
    "DamperCharacterized",
    "DamperInspected",
    "DiagnosisResults",
    "FitOptions",
    "FitResults",
    "Guessed",
    "Imported",
    "ImprovementResults",
    "Inspection",
    "JointlyFitted",
    "Judging",
    "ModelLike",
    "ModelsCompared",
    "PlanResults",
    "Reader",
    "Recording",
    "ReplayOptions",
    "ReplayResults",
    "ReplaySetup",
    "Tally",
    "Tare",
    "WrittenC",
    "WrittenFmu",
    "asked",
    "characterize",
    "compare",
    "diagnose",
    "diagnose_case",
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
    "judging_of",
    "model_for",
    "models_for",
    "no_force",
    "opened",
    "output_paths",
    "page_title",
    "plan",
    "read",
    "replay",
    "replay_bag",
    "replay_to",
    "save_fit",
    "signal_map_of",
    "structure_of",
    "tare",
    "to_c",
    "to_fmu",
]
__getattr__, __dir__ = lazy_names(__name__, __file__)
