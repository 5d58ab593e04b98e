"""The page of a model's whole story: the data, the model before, what was found, the model after, its parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from damper_estimator.diagnosis import Diagnosis, Step
from damper_estimator.numbers import number
from damper_estimator.report.curve_figures import curve_figures, curve_text
from damper_estimator.report.diagnosis_page import SCRIPT, STYLES, tied_notes
from damper_estimator.report.diagnosis_wording import finding_text, model_rows, moved_rows, rejected_rows, step_name
from damper_estimator.report.figures import error_map
from damper_estimator.report.forces import forces_figure
from damper_estimator.report.page import render
from damper_estimator.report.plots import shared_arrays
from damper_estimator.report.verdict_figures import atlas_figure, error_bars, ranking_figure, waterfall_figure
from damper_estimator.report.wording import (
    MEASURES,
    error_parts,
    finding_rows,
    headline,
    in_signs,
    measure_text,
    quality_rows,
    recording_name,
)
from damper_estimator.validation import Comparison

_LEAST_STEPS = 2  # for a waterfall; the model as given is the first


@dataclass(frozen=True)
class Story:
    """What the report says about one damper.

    Attributes:
        damper: its name.
        before, after: the model as given and as it is now, over the same measurements; the same without a change.
        steps: from the model as given to the one of now.
        diagnosis: the last one; None where there was none.
        notes: what a reader must know of the data, such as what was left out.
    """

    damper: str
    before: Comparison
    after: Comparison
    steps: Sequence[Step]
    diagnosis: Diagnosis | None = None
    notes: Sequence[str] = ()


def story_page(story: Story, title: str) -> str:
    """The whole page as HTML; it is self-contained and needs no network."""
    return render("story.html", title, [_text(story)], STYLES, SCRIPT, shared_arrays([_figures(story)]))


def _text(story: Story) -> dict[str, object]:
    found, both = story.diagnosis, _both(story)
    text = {
        "damper": story.damper,
        "headline": _headline(story),
        "notes": list(story.notes),
        "recordings": [recording_name(path) for path in story.before.recordings],
        "data": finding_rows(story.before),
        "quality": quality_rows(story.before),
        "models": [_model(comparison, name) for name, comparison in both.items()],
        "measures": [{"name": name, "unit": unit, "meaning": meaning} for _, name, unit, meaning in MEASURES],
        "steps": [_step(step) for step in story.steps],
        "parameters": model_rows(story.after.model),
        "before_parameters": model_rows(story.before.model) if len(both) > 1 else [],
        "findings": [],
        "diagnosed": found is not None,
    }
    if found is not None:
        text |= curve_text(found) | {
            "sentence": found.sentence,
            "findings": [finding_text(finding) for finding in found.findings],
            "moved": moved_rows(found),
            "rejected": rejected_rows(found.ranking, found.untestable),
        }
    return text


def _headline(story: Story) -> str:
    before, after = (comparison.measures.rmse_n for comparison in (story.before, story.after))
    done = len(story.steps) - 1
    if not done:
        return headline([story.before])
    many = "one step" if done == 1 else f"{done} steps"
    share = number(100.0 * story.after.measures.nrmse)
    return (
        f"{story.before.model.name}: {many} took its error from {number(before)} to {number(after)} N rms, {share} % "
        "of the force."
    )


def _model(comparison: Comparison, name: str) -> dict[str, object]:
    record = comparison.measures.record()
    return {
        "name": name,
        "cells": [measure_text(key, record[key]) for key, *_ in MEASURES],
        "parts": error_parts(comparison),
        "sentences": comparison.split.sentences,
        "regions": [{"where": in_signs(r.where), "what": in_signs(r.what), "error": 100.0 * r.share_of_squared_error}
                    for r in comparison.regions[:5]],
    }  # fmt: skip


def _step(step: Step) -> dict[str, str]:
    return {"name": step_name(step), "fit": number(step.rmse_fit_n), "unseen": number(step.rmse_unseen_n)}


def _both(story: Story) -> dict[str, Comparison]:
    if len(story.steps) < _LEAST_STEPS:
        return {story.before.model.name: story.before}
    name = story.after.model.name
    return {f"{name}, now": story.after, f"{story.before.model.name}, as given": story.before}


def _figures(story: Story) -> dict[str, object]:
    both = [
        replace(comparison, model=replace(comparison.model, name=name)) for name, comparison in _both(story).items()
    ]
    figures: dict[str, object] = {"forces": forces_figure(both), "errors": _errors(story)}
    figures |= {
        f"map{i}": drawn for i, drawn in enumerate(_on_one_scale([error_map(comparison) for comparison in both]))
    }
    found = story.diagnosis
    if found is not None:
        figures["ranking"] = ranking_figure(found.ranking, found.findings, tied_notes(found))
        figures["atlas"] = atlas_figure(found.atlas, found.findings)
        figures |= curve_figures(found)
    return figures


def _errors(story: Story) -> dict[str, object]:
    floor, steps = story.after.noise_floor_n, list(story.steps)
    reference = story.diagnosis.reference_n if story.diagnosis else float("nan")
    if len(steps) < _LEAST_STEPS:
        force = story.after.measures.force_rms_n
        return error_bars([(step_name(steps[0]), steps[0].rmse_unseen_n)], floor, force, reference)
    return waterfall_figure(SimpleNamespace(steps=steps, noise_floor_n=floor, reference_n=reference))


def _on_one_scale(maps: Sequence[Mapping]) -> list[dict[str, object]]:
    """Maps of the error whose colours mean the same."""
    values = [v for drawn in maps for row in drawn["data"][0]["z"] for v in row if v is not None]
    top = float(np.quantile(values, 0.995)) if values else 1.0
    return [{**drawn, "data": [{**drawn["data"][0], "zmin": 0.0, "zmax": top}]} for drawn in maps]
