"""The page of ``diagnose``: the verdict, what could explain the error, where the model fails, before and after."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis import Diagnosis, Finding
from damper_estimator.report.before_after import BeforeAfter, before_after, explained
from damper_estimator.report.before_after_figures import (
    cloud_figure,
    contribution_figure,
    error_maps,
    explained_figure,
    loops_figure,
    passage_figure,
    structure_figure,
)
from damper_estimator.report.curve_figures import curve_figures, curve_text
from damper_estimator.report.diagnosis_wording import (
    correction_rows,
    data_rows,
    finding_text,
    listed,
    moved_rows,
    plain_name,
    rejected_rows,
    stretches_sentence,
)
from damper_estimator.report.page import render
from damper_estimator.report.plots import shared_arrays
from damper_estimator.report.used_stretches import stretches_figure
from damper_estimator.report.verdict_figures import (
    atlas_figure,
    error_bars,
    moved_figure,
    ranking_figure,
)
from damper_estimator.report.wording import quality_rows, recording_name

STYLES = ("page.css", "diagnosis.css")
SCRIPT = "plots.js"


@dataclass(frozen=True)
class DiagnosisSection:
    """One damper of the page, reduced to what is shown.

    Attributes:
        text: what the template fills in.
        figures: what the page's script draws, by name.
    """

    text: dict[str, object]
    figures: dict[str, object]


def diagnosis_section(damper: str, found: Diagnosis) -> DiagnosisSection:
    """The part of the page about one damper."""
    shown = before_after(found)
    figures = force_figures(shown, found.findings) | {
        "errors": error_bars(_levels(found), found.noise_floor_n, found.force_rms_n, found.reference_n),
        "ranking": ranking_figure(found.ranking, found.findings, tied_notes(found)),
        "atlas": atlas_figure(found.atlas, found.findings),
    }
    figures |= curve_figures(found)
    if found.stretches:
        figures["stretches"] = stretches_figure(found)
    if found.moved:
        figures["moved"] = moved_figure(found.moved)
    if found.structure is not None:
        figures["structure"] = structure_figure(found.structure)
    text = force_text(shown, found.findings, figures) | curve_text(found)
    text |= {
        "damper": damper,
        "headline": found.sentence,
        "moved": moved_rows(found),
        "structure": "" if found.structure is None else found.structure.words,
        "rejected": rejected_rows(found.ranking, found.untestable),
        "data": data_rows(found),
        "stretches": stretches_sentence(found),
        "corrections": correction_rows(found),
    }
    return DiagnosisSection(text, figures)


def diagnosis_page(sections: Sequence[DiagnosisSection], title: str) -> str:
    """The whole page as HTML; it is self-contained and needs no network."""
    return render(
        "diagnosis.html",
        title,
        [section.text for section in sections],
        STYLES,
        SCRIPT,
        shared_arrays([section.figures for section in sections]),
    )


def force_figures(shown: BeforeAfter, findings: Sequence[Finding]) -> dict[str, object]:
    """What both pages show of forces and errors."""
    figures = {
        "maps": error_maps(shown),
        "passage": passage_figure(shown),
        "loops": loops_figure(shown),
        "over_velocity": cloud_figure(shown, "velocity"),
        "over_displacement": cloud_figure(shown, "displacement"),
        "contributions": contribution_figure(shown.after.contributions, {f.effect for f in findings}),
    }
    chain = [finding for finding in findings if finding.is_channel]
    for index, finding in enumerate(findings):
        # Corrections of the measurement chain are shown together: what was measured is read again with all of them.
        drawn = None if finding in chain[1:] else explained(shown, finding)
        if drawn is not None:
            name = listed([fault.phenomenon for fault in chain], "and") if finding.is_channel else finding.phenomenon
            figures[f"explained{index}"] = explained_figure(shown, drawn, plain_name(name))
    return figures


def force_text(shown: BeforeAfter, findings: Sequence[Finding], figures: dict[str, object]) -> dict[str, object]:
    """The words that go with ``force_figures``."""
    start, end = shown.worst.worst
    chain = listed([finding.phenomenon for finding in findings if finding.is_channel], "and")
    return {
        "findings": [
            finding_text(finding)
            | {"drawn": f"explained{index}" in figures}
            | ({"accounted": chain} if finding.is_channel else {})
            for index, finding in enumerate(findings)
        ],
        "changed": shown.changed,
        "worst": f"{recording_name(shown.worst.path)}, {start:.1f} to {end:.1f} s",
        "quality": quality_rows(shown.before),
        "chain": _chain(shown),
    }


def _chain(shown: BeforeAfter) -> str:
    zeros = [f"{np.mean(recording.zero):+.3g} N" for recording in shown.recordings]
    return (
        "forces in the comparison band, judged from 0.2 s after a reset on; the gauge's zero and straight drift of "
        f"each recording are left out (here {', '.join(zeros)} on average)"
    )


def tied_notes(found: Diagnosis) -> dict[str, str]:
    """For the hover: what the found phenomena cannot be distinguished from."""
    names = {name: finding.phenomenon for finding in found.findings for name in finding.tied_with}
    return {
        judged.effect: f"cannot be distinguished from {plain_name(names[judged.phenomenon])}"
        for judged in found.ranking
        if judged.phenomenon in names
    }


def _levels(found: Diagnosis) -> list[tuple[str, float]]:
    """Unseen error from the model as given to the improved one."""
    if not found.findings:
        levels = [("model as given", found.rmse_n)]
    else:
        levels = [("model as given", found.findings[0].rmse_before_n)]
    if found.verdict == "parameters_changed" and np.isfinite(found.rmse_refit_alone_n):
        return [*levels, ("re-identified", found.rmse_refit_alone_n)]
    with_it: list[tuple[str, float]] = []
    for finding in found.findings:
        name = f"with {plain_name(finding.phenomenon)}"
        # Of a pair both have the error after the two.
        if with_it and finding.partner and with_it[-1][1] == finding.rmse_after_n:
            name = f"{with_it.pop()[0]} {name.replace('with', 'and', 1)}"
        with_it.append((name, finding.rmse_after_n))
    return levels + [("and " + name if i else name, value) for i, (name, value) in enumerate(with_it)]
