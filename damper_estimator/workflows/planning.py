"""Which test to drive next: the one that tells tied explanations apart, or that sharpens a model's parameters."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.planning import Plan, Rig, drive_csv, load_rig, plan_yaml
from damper_estimator.planning import plan as planned
from damper_estimator.workflows.diagnosis import DiagnosisResults, diagnose_case
from damper_estimator.workflows.judging import Case, Tell, judging_of, silent
from damper_estimator.workflows.models import ModelLike
from damper_estimator.workflows.recording import Recording, in_words
from damper_estimator.workflows.results import Results

RIG = "servo_hydraulic"
"""Where nothing else is said."""

DiagnosisLike = str | Path | DiagnosisResults
"""What ``diagnose`` found: its result, or the file that it wrote with ``--json``."""


@dataclass(frozen=True, repr=False, eq=False)
class PlanResults(Results[Plan]):
    """Tests to drive, by damper.

    For one damper (``result["front_left"]`` where there are several) the plan is at hand.
    """

    @property
    def plan(self) -> Plan:
        """The test for one damper."""
        return self.only

    @property
    def sentence(self) -> str:
        """What the test is expected to give, in one sentence."""
        return self.only.sentence

    def page(self) -> str:
        """One self-contained HTML page: what will differ, and how sure the decision will be."""
        from damper_estimator.report import plan_page

        return plan_page(self.by_damper, f"a test after {in_words(self.asked['bags'])}")

    def save(self, path: str | Path) -> Path:
        """Writes ``drive.csv``, ``plan.yaml`` and ``plan.html`` into a folder (one per damper where there are several);
        ``.json`` is the record, ``.html`` the page.

        Raises:
            InputError: where it cannot be written.
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
        own, files = self.only, [folder / "plan.yaml", folder / "plan.html"]
        if own.rig.kind != "manoeuvres":
            files.append(folder / "drive.csv")
        texts = [plan_yaml(own, self.asked), self.page(), *([drive_csv(own)] if len(files) > 2 else [])]
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another place with -o") from error
        for file, text in zip(files, texts, strict=True):
            write_text(file, text)
        return files

    def _record(self, own: Plan) -> dict[str, object]:
        return own.record()

    def _line(self, own: Plan) -> str:
        return own.sentence

    def _rows(self, own: Plan) -> list[dict[str, object]]:
        return [step.record() for step in own.steps]

    def _figure(self, own: Plan) -> Mapping[str, object]:
        from damper_estimator.report import plan_figure

        return plan_figure(own)


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
    progress: Tell | None = None,
) -> PlanResults:
    """The test that tells apart what a diagnosis left tied, as soon as it can, within the limits of a rig.

    Args:
        recording: what the diagnosis was made on; several are pooled.
        model: that was diagnosed.
        diagnosis: its result, or the file that ``diagnose --json`` wrote; without, the recordings are diagnosed first.
        rig: a name of the library, a rig file, or a rig.
        travel: m, lowest and highest displacement that the damper allows; None for the rig's file, or what the
            recordings drove.
        minutes: length of the test; None for the shortest that decides rightly with 95 %, at most ten.
        parameters: sharpen the model's parameters instead; no diagnosis is needed.
        workers: processes for the diagnosis.
        progress: receives what goes on and its share of the work, 0 to 1.

    Raises:
        InputError: one line; where nothing is tied, for limits that leave nothing to drive, and as ``diagnose``.
    """
    test_rig = rig if isinstance(rig, Rig) else load_rig(rig)
    if travel is not None:
        if not travel[0] < travel[1]:
            raise InputError(f"travel from {travel[0]:g} to {travel[1]:g} m: the lowest comes first")
        test_rig = replace(test_rig, travel=travel)
    given = judging_of(recording, model, None, "plan")
    names = list(recording.names)
    tell = progress or silent
    found: dict[str, Plan] = {}
    known = None if parameters else _tied_of(diagnosis)
    for case in given.cases:
        group = () if parameters else _group(case, known, workers, tell)
        if group is not None:
            found[case.damper] = planned(case.model, case.fit, group, test_rig, minutes=minutes, progress=tell)
    if not found:
        raise InputError(
            f"{in_words(names)}: no damper has a tied finding, so nothing is to be told apart; "
            "--parameters sharpens the model instead"
        )
    asked = {"bags": names, "model": given.asked["model"], "rig": test_rig.name}
    return PlanResults(asked, found)


def _tied_of(diagnosis: DiagnosisLike | None) -> dict[str, tuple[str, ...] | None] | None:
    """By damper the first group of tied phenomena, None where there is none; None without a diagnosis."""
    if diagnosis is None:
        return None
    if isinstance(diagnosis, DiagnosisResults):
        return {name: _first([(one.phenomenon, *one.tied_with) for one in own.findings])
                for name, own in diagnosis.by_damper.items()}  # fmt: skip
    path = Path(diagnosis)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {
            str(name): _first([(str(one["phenomenon"]), *map(str, one["tied_with"])) for one in own["findings"]])
            for name, own in content["dampers"].items()
        }
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the file of diagnose --json") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(f"{path}: is no diagnosis; give the file that diagnose --json wrote") from error


def _first(groups: list[tuple[str, ...]]) -> tuple[str, ...] | None:
    return next((group for group in groups if len(group) > 1), None)


def _group(
    case: Case, known: dict[str, tuple[str, ...] | None] | None, workers: int, tell: Tell
) -> tuple[str, ...] | None:
    """The tied phenomena of one damper; None where there are none."""
    if known is not None:
        if case.damper not in known:
            raise InputError(
                f"the diagnosis has no damper {case.damper}; it has {', '.join(known) or 'none'}; choose one with -d"
            )
        return known[case.damper]
    found = diagnose_case(case, "both", workers, tell)
    return _first([(one.phenomenon, *one.tied_with) for one in found.findings])
