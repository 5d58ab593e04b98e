"""Plans the next test: one that separates tied explanations, or that makes a model's parameters more certain."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from damper_estimator.diagnosis import Diagnosis
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.planning import Plan, Rig, drive_csv, load_rig, plan_yaml
from damper_estimator.planning import plan as planned
from damper_estimator.workflows.cases import Case, Progress, diagnosis_cases, no_progress
from damper_estimator.workflows.diagnosis import DiagnosisResults, diagnose_case
from damper_estimator.workflows.model_arguments import ModelLike
from damper_estimator.workflows.recording import Recording, in_words
from damper_estimator.workflows.results import Results

RIG = "servo_hydraulic"
"""Default rig."""

DiagnosisLike = str | Path | DiagnosisResults
"""A diagnosis: the result of ``diagnose``, or the file that it wrote with ``--json``."""


@dataclass(frozen=True)
class Tie:
    """What a diagnosis left undecided.

    Attributes:
        group: tied phenomena; empty if the model's parameters are to become more certain.
        probable: probability of each phenomenon that the diagnosis tried; None if unknown.
    """

    group: tuple[str, ...]
    probable: Mapping[str, float] | None = None


@dataclass(frozen=True, repr=False, eq=False)
class PlanResults(Results[Plan]):
    """Tests to drive, by damper.

    The properties are those of one damper (``result["front_left"]`` selects one of several).
    """

    @property
    def plan(self) -> Plan:
        """The test for one damper."""
        return self.only

    @property
    def sentence(self) -> str:
        """The expected outcome of the test in one sentence."""
        return self.only.sentence

    def page(self) -> str:
        """One self-contained HTML page: expected differences, and certainty of the decision."""
        from damper_estimator.report import plan_page

        return plan_page(self.by_damper, f"a test after {in_words(self.request['bags'])}")

    def save(self, path: str | Path) -> Path:
        """Writes ``drive.csv``, ``plan.yaml`` and ``plan.html`` into a folder (one per damper if there are several);
        ``.json`` is the record, ``.html`` the page.

        Raises:
            InputError: if it cannot be written.
        """
        path = Path(path)
        if path.suffix in (".json", ".html"):
            return super().save(path)
        if path.is_file():
            raise InputError(f"{path}: is a file; name a folder for the plan")
        for damper in self:
            self[damper].write(path / damper if len(self) > 1 else path)
        return path

    def write(self, folder: Path) -> list[Path]:
        """Writes the files of one damper into a folder; returns them."""
        test_plan, files = self.only, [folder / "plan.yaml", folder / "plan.html"]
        if test_plan.rig.kind != "manoeuvres":
            files.append(folder / "drive.csv")
        texts = [plan_yaml(test_plan, self.request), self.page(), *([drive_csv(test_plan)] if len(files) > 2 else [])]
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be created ({error.strerror}); choose another place with -o") from error
        for file, text in zip(files, texts, strict=True):
            write_text(file, text)
        return files

    def _record(self, result: Plan) -> dict[str, object]:
        return result.record()

    def _line(self, result: Plan) -> str:
        return result.sentence

    def _rows(self, result: Plan) -> list[dict[str, object]]:
        return [step.record() for step in result.steps]

    def _figure(self, result: Plan) -> Mapping[str, object]:
        from damper_estimator.report import plan_figure

        return plan_figure(result)


def plan(
    recording: Recording,
    model: ModelLike,
    *,
    diagnosis: DiagnosisLike | None = None,
    rig: str | Path | Rig = RIG,
    travel: tuple[float, float] | None = None,
    minutes: float | None = None,
    parameters: bool = False,
    workers: int = 1,
    progress: Progress | None = None,
) -> PlanResults:
    """The shortest test that separates explanations which a diagnosis left tied, within the limits of a rig.

    Args:
        recording: recordings of the diagnosis, pooled.
        model: the diagnosed model.
        diagnosis: its result, or the file that ``diagnose --json`` wrote; None runs a diagnosis first.
        rig: a name of the library, a rig file, or a rig.
        travel: m, lowest and highest displacement that the damper allows; None for those in the rig's file, or of
            the recordings.
        minutes: length of the test; None for the shortest with a correct decision in 95 % of cases, at most ten; two
            for parameters.
        parameters: make the model's parameters more certain instead; needs no diagnosis.
        workers: processes for the diagnosis.
        progress: receives the current activity and the completed share of the work, 0 to 1.

    Raises:
        InputError: if nothing is tied, for limits that permit no test, and as ``diagnose``.
    """
    test_rig = rig if isinstance(rig, Rig) else load_rig(rig)
    if travel is not None:
        if not travel[0] < travel[1]:
            raise InputError(f"travel from {travel[0]:g} to {travel[1]:g} m: give the lower limit first")
        test_rig = replace(test_rig, travel=travel)
    cases = diagnosis_cases(recording, model, None, "plan")
    names = list(recording.names)
    report = progress or no_progress
    found: dict[str, Plan] = {}
    known = None if parameters else _tied_of(diagnosis)
    for case in cases.cases:
        tie = Tie(()) if parameters else _tie(case, known, workers, report)
        if tie is not None:
            found[case.damper] = planned(
                case.model, case.fit, tie.group, test_rig, probable=tie.probable, minutes=minutes, progress=report
            )
    if not found:
        raise InputError(
            f"{in_words(names)}: no damper has tied findings that a test could separate; "
            "--parameters plans a test that makes the model's parameters more certain"
        )
    request = {"bags": names, "model": cases.request["model"], "rig": test_rig.name}
    return PlanResults(request, found)


def plan_case(case: Case, tie: Tie, rig: str | Path, minutes: float | None, progress: Progress) -> PlanResults:
    """The test for one damper that separates tied phenomena; without any, for its model's parameters.

    Raises:
        InputError: as `plan`.
    """
    test_rig, measurements = load_rig(rig), (*case.fit, *case.unseen)
    found = planned(
        case.model, measurements, tie.group, test_rig, probable=tie.probable, minutes=minutes, progress=progress
    )
    names = list(dict.fromkeys(measurement.recording for measurement in measurements))
    return PlanResults({"bags": names, "model": case.model.name, "rig": test_rig.name}, {case.damper: found})


def ties_of(found: Diagnosis) -> list[Tie]:
    """The ties among the findings of a diagnosis, in their order."""
    groups = [(finding.phenomenon, *finding.tied_with) for finding in found.findings]
    return _ties(groups, {one.phenomenon: one.probability for one in found.phenomena})


def _ties(groups: Sequence[tuple[str, ...]], probabilities: Mapping[str, float]) -> list[Tie]:
    """Of findings, each with those tied with it; the probabilities are those of the round of the first finding."""
    found = []
    for number, group in enumerate(groups):
        is_known = not number and all(probabilities.get(name, 0.0) > 0.0 for name in group)
        if len(group) > 1:
            found.append(Tie(group, dict(probabilities) if is_known else None))
    return found


def _tied_of(diagnosis: DiagnosisLike | None) -> dict[str, Tie | None] | None:
    """The first tie by damper, None if it has none; None without a diagnosis."""
    if diagnosis is None:
        return None
    if isinstance(diagnosis, DiagnosisResults):
        return {name: _first(ties_of(result)) for name, result in diagnosis.by_damper.items()}
    path = Path(diagnosis)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {str(name): _tie_written(result) for name, result in content["dampers"].items()}
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the file of diagnose --json") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(f"{path}: is not a diagnosis; give the file that diagnose --json wrote") from error


def _tie_written(result: Mapping[str, Any]) -> Tie | None:
    groups = [(str(finding["phenomenon"]), *map(str, finding["tied_with"])) for finding in result["findings"]]
    rows = result.get("phenomena", ())
    return _first(_ties(groups, {str(row["phenomenon"]): float(row["probability"]) for row in rows}))


def _first(ties: Sequence[Tie]) -> Tie | None:
    return next(iter(ties), None)


def _tie(case: Case, known: dict[str, Tie | None] | None, workers: int, report: Progress) -> Tie | None:
    """What is tied for one damper; None if nothing is."""
    if known is not None:
        if case.damper not in known:
            raise InputError(
                f"the diagnosis has no damper {case.damper}; it has {', '.join(known) or 'none'}; choose one with -d"
            )
        return known[case.damper]
    return _first(ties_of(diagnose_case(case, "both", workers, report)))
