"""The page of ``improve``: the error over the steps down to the noise floor, and what was tried at each of them."""

from collections.abc import Sequence

from damper_estimator.diagnosis import Diagnosis, Finding, Improvement
from damper_estimator.numbers import number
from damper_estimator.report.before_after import before_after, first_diagnosis
from damper_estimator.report.curve_figures import curve_figures, curve_text
from damper_estimator.report.diagnosis_page import (
    SCRIPT,
    STYLES,
    DiagnosisSection,
    force_figures,
    force_text,
    tied_notes,
)
from damper_estimator.report.diagnosis_wording import (
    correction_rows,
    data_rows,
    finding_text,
    model_rows,
    rejected_rows,
    step_name,
    stretches_sentence,
)
from damper_estimator.report.page import render
from damper_estimator.report.plots import shared_arrays
from damper_estimator.report.used_stretches import stretches_figure
from damper_estimator.report.verdict_figures import ranking_figure, waterfall_figure


def improvement_section(damper: str, found: Improvement) -> DiagnosisSection:
    """The part of the page about one damper."""
    shown = before_after(found)
    kept = _kept(found)
    figures = force_figures(shown, kept) | {"waterfall": waterfall_figure(found)}
    figures |= curve_figures(found.final)
    if found.final.stretches:
        figures["stretches"] = stretches_figure(found.final)
    for index, diagnosis in enumerate([*_searches(found), found.final]):
        if diagnosis is not None:
            figures[f"tried{index}"] = ranking_figure(diagnosis.ranking, diagnosis.findings, tied_notes(diagnosis))
    text = force_text(shown, kept, figures) | curve_text(found.final)
    if found.first is not found.final:
        figures |= curve_figures(found.first, "first_curve")
        text["first_curves"] = curve_text(found.first, "first_curve")
    text |= {
        "damper": damper,
        "headline": found.sentence,
        "steps": _steps(found),
        "data": data_rows(first_diagnosis(found)),
        "stretches": stretches_sentence(found.final),
        "corrections": correction_rows(found),
        "parameters": model_rows(found.model),
    }
    return DiagnosisSection(text, figures)


def improvement_page(sections: Sequence[DiagnosisSection], title: str) -> str:
    """The whole page as HTML; it is self-contained and needs no network."""
    return render(
        "improvement.html",
        title,
        [section.text for section in sections],
        STYLES,
        SCRIPT,
        shared_arrays([section.figures for section in sections]),
    )


def _kept(found: Improvement) -> tuple[Finding, ...]:
    """Findings of the steps that are in the improved model or in the corrected signal map."""
    kept: dict[str, Finding] = {}
    for step in found.steps:
        for label in step.replaced:
            kept.pop(label.partition("#")[0], None)
        if step.action == "prune":
            kept.pop(step.effect or "", None)
        elif step.diagnosis is not None:
            kept |= {finding.effect: finding for finding in step.diagnosis.findings if finding.effect == step.effect}
    return tuple(kept.values())


def _searches(found: Improvement) -> list[Diagnosis | None]:
    """The diagnosis before each step, where it is the first that follows from it."""
    searches: list[Diagnosis | None] = []
    for step in found.steps:
        searches.append(None if any(step.diagnosis is known for known in searches) else step.diagnosis)
    return searches


def _steps(found: Improvement) -> list[dict[str, object]]:
    """The steps in words, and the last search, which found nothing more."""
    rows = []
    for index, (step, diagnosis) in enumerate(zip(found.steps, _searches(found), strict=True)):
        rows.append(
            {
                "action": step.action,
                "name": step_name(step),
                "error": f"{number(step.rmse_unseen_n)} N unseen, {number(step.rmse_fit_n)} N fitted",
                "note": step.note if step.action != "start" else "",
                "tried": diagnosis is not None,
                "figure": f"tried{index}",
                "findings": [] if diagnosis is None else [finding_text(finding) for finding in diagnosis.findings],
                "rejected": [] if diagnosis is None else rejected_rows(diagnosis.ranking, diagnosis.untestable),
            }
        )
    name = "nothing more takes error away" if found.final.findings else "nothing more is justified"
    last = {"action": "final", "name": name, "error": "", "note": "", "tried": True}
    rejected = rejected_rows(found.final.ranking, found.final.untestable)
    return [*rows, last | {"figure": f"tried{len(found.steps)}", "findings": [], "rejected": rejected}]
