"""What the page says next to the figures: agreement, regions, data quality, what is missing."""

from collections.abc import Sequence

import numpy as np
from dash import html

from damper_estimator.diagnosis import Diagnosis
from damper_estimator.effects.discovery import all_effects
from damper_estimator.report.diagnosis_wording import (
    finding_text,
    moved_rows,
    plain_name,
    rejected_rows,
    stretches_sentence,
)
from damper_estimator.report.verdict_figures import ranked
from damper_estimator.report.wording import MEASURES, finding_rows, headline, in_signs, measure_text, quality_rows
from damper_estimator.studio.model_run import ModelRun
from damper_estimator.validation import Comparison

Piece = html.Div


def measures_table(models: Sequence[ModelRun], names: Sequence[str]) -> Piece:
    """Agreement of each model over all samples."""
    head = html.Thead(
        html.Tr(
            [html.Th("model", scope="col")]
            + [
                html.Th([name, html.Small(f" {unit}")] if unit else name, scope="col", title=meaning)
                for _, name, unit, meaning in MEASURES
            ]
        )
    )
    rows = []
    for i, (run, name) in enumerate(zip(models, names, strict=True)):
        record = run.measures.record()
        key = html.I(className=f"key model{i % 5}")
        cells = [html.Td(measure_text(measure, record[measure])) for measure, *_ in MEASURES]
        rows.append(html.Tr([html.Th([key, name], scope="row"), *cells]))
    return html.Table([head, html.Tbody(rows)], className="measures")


def verdict(comparison: Comparison, note: str, warnings: Sequence[str], offer: str = "") -> Piece:
    """The comparison in a sentence, mistakes of the recordings first; ``offer``: a model that was never identified."""
    warned = [html.P(text, className="warning") for text in (*warnings, *comparison.warnings)]
    data = [
        html.Li([row["sentence"], html.Br(), html.Small(f"what to do: {row['remedy']}")])
        for row in finding_rows(comparison)
    ]
    if data:
        warned.append(html.Section([html.H2("Data before physics"), html.Ul(data)], className="warning findings"))
    noted = [html.P(note, className="hint")] if note else []
    offered = []
    if offer:
        words = f"{offer} was never identified: its numbers are not those of this damper. "
        button = html.Button("Refit", id={"type": "refit", "from": "verdict"}, className="primary")
        offered = [html.P([words, button], className="warning")]
    return html.Div([*offered, html.P(headline([comparison]), className="statement"), *warned, *noted])


def regions(comparison: Comparison) -> Piece:
    """Where the model fails: one button per region."""
    if not comparison.regions:
        return html.P("The error is spread evenly: no region of operation carries much more of it than of the time.")
    rows = []
    for i, region in enumerate(comparison.regions):
        error, samples = 100.0 * region.share_of_squared_error, 100.0 * region.share_of_samples
        bars = html.Span(
            [
                html.Span(className="bar error", style={"width": f"{error:.1f}%"}),
                html.Span(className="bar samples", style={"width": f"{samples:.1f}%"}),
            ],
            className="bars",
        )
        words = [
            html.Span(in_signs(region.where), className="where"),
            html.Span(in_signs(region.what), className="what"),
        ]
        share = html.Span(f"{error:.0f} %", className="share")
        rows.append(html.Li(html.Button([*words, bars, share], id={"type": "region", "index": i}, className="region")))
    hint = [html.I(className="bar error"), " share of the squared error ", html.I(className="bar samples")]
    return html.Div(
        [
            html.P([*hint, " share of the time; choose one to go there"], className="hint"),
            html.Ol(rows, className="regions"),
        ]
    )


def quality(comparison: Comparison) -> Piece:
    """What is wrong with the recording."""
    rows = [
        html.Tr([html.Th(row["name"], scope="row"), html.Td(row["text"] + (" ⚠" if row["bad"] else ""))],
                className="bad" if row["bad"] else "")
        for row in quality_rows(comparison)
    ]  # fmt: skip
    return html.Table(html.Tbody(rows), className="quality")


def quality_line(comparison: Comparison, warnings: Sequence[str]) -> list:
    """The quality of the data in a line: how much there is, and all that is suspicious."""
    rows = quality_rows(comparison)
    doubtful = [f"{row['text']} {row['name']}" for row in rows[:1]] + [row["text"] for row in rows[1:2]]
    bad = [f"{row['name']} {row['text']}" for row in rows if row["bad"]]
    more = len(comparison.findings) + len(warnings)
    if more:
        bad.append(f"{more} more under Where it fails")
    doubts = html.Span(f"⚠ {', '.join(bad)}", className="bad") if bad else "nothing suspicious"
    return [f"data: {', '.join(doubtful)}, ", doubts]


def findings(found: Diagnosis, stale: bool, region: str = "") -> Piece:
    """The verdict and the effects that are missing, each with a button that adds it; ``region`` was diagnosed alone."""
    parts: list[Piece] = [html.P(found.sentence, className="statement")]
    if found.stretches:
        parts.append(html.P(stretches_sentence(found)))
    if region:
        parts.append(html.P(f"Of the marked {region} alone: found on 60 % of its samples, judged on the others."))
    if stale:
        parts.append(
            html.P("The model was changed since: run the diagnosis again to see what is left.", className="warning")
        )
    parts += [_finding(finding) for finding in found.findings]
    moved = moved_rows(found)
    if moved:
        text = "; ".join(f"{row['name']} {row['before']} → {row['after']} {row['unit']}" for row in moved)
        parts.append(html.P(f"Parameters that moved: {text}. Refit under Model."))
    if found.structure is not None:
        parts.append(html.P(f"Unexplained: {found.structure.words}"))
    return html.Div(parts)


def _finding(finding) -> Piece:
    text = finding_text(finding)
    facts = [
        ("confidence", text["confidence"]),
        ("of the explainable error", text["share"]),
        ("unseen error", text["errors"]),
    ]
    where = "correct the signal map" if finding.is_channel else "add and refit"
    add = html.Button(where, id={"type": "add", "effect": finding.effect, "from": "finding"}, className="primary")
    tied = []
    if text["tied"]:
        group = "+".join((finding.phenomenon, *finding.tied_with))
        button = html.Button("Plan the test that decides", id={"type": "plan-tie", "group": group})
        tied = [html.P([f"These data cannot distinguish it from {text['tied']}. ", button], className="tied")]
    remark = [html.P(text["remark"])] if text["remark"] else []
    return html.Section(
        [
            html.Div(
                [
                    html.H2([text["name"], html.Small(f" by {finding.effect}")]),
                    *([add] if finding.parameters else []),  # nothing corrects a zero that moves
                ],
                className="title",
            ),
            html.Ul([html.Li([html.B(value), html.Span(name)]) for name, value in facts], className="facts"),
            *tied,
            html.P(text["evidence"]),
            *remark,
            html.P([html.Span("to be sure", className="label"), text["test"]]),
        ],
        className="finding",
        **{"data-effect": finding.effect},
    )


def candidates(found: Diagnosis) -> Piece:
    """Every phenomenon that was tried: hovering shows what it would explain, the button adds it."""
    rows = []
    for effect in ranked(found.ranking, found.findings):
        best = max((way for way in (effect.kept, effect.refitted) if way is not None), key=lambda way: way.gain)
        gain = f"{100.0 * best.gain:z.0f} % ({100.0 * best.low:z.0f} to {100.0 * best.high:z.0f})"
        button = html.Button(
            "add",
            id={"type": "add", "effect": effect.effect, "from": "ranking"},
            title=f"add {effect.effect} and refit",
        )
        name = html.Span(
            [html.B(plain_name(effect.phenomenon)), html.Small(f" {effect.effect}")], tabIndex="0", className="looked"
        )
        rows.append(
            html.Li([name, button, html.Span(f"{gain}: {effect.reason or 'found'}")], **{"data-effect": effect.effect})
        )
    untried = list(rejected_rows((), found.untestable))
    more = [html.Details([html.Summary(f"{len(untried)} could not be tried"), html.Ul(
        [html.Li(f"{row['effect']}: {row['reason'].removeprefix('not tried: ')}") for row in untried])])]  # fmt: skip
    hint = html.P("Point at one, or reach it with Tab, to see its equation and what it explains.", className="hint")
    return html.Div([hint, html.Ol(rows, className="candidates"), *(more if untried else [])])


def equation(effect: str) -> Piece:
    """What an effect is, in its author's words: the equation, symbols, source."""
    declared = all_effects()[effect]
    shows = [html.P([html.Span("shows as", className="label"), declared.shows])] if declared.shows else []
    return html.Div([html.Pre(declared.description.strip().replace("``", ""), className="equation"), *shows])


def steps_list(errors: Sequence[float], names: Sequence[str], files: Sequence[str], at: int) -> Piece:
    """The steps in words, with the file that each was saved to; those that were undone are pale."""
    rows = []
    for i, (error, name, file) in enumerate(zip(errors, names, files, strict=True)):
        unseen = f"{error:.4g} N" if np.isfinite(error) else "–"
        state = "undone" if i > at else ("now" if file or not i else "now unsaved") if i == at else ""
        saved = [html.Small(f", saved as {file}")] if file else []
        rows.append(html.Li([html.B(name), f" {unseen} unseen", *saved], className=state))
    return html.Ol(rows, className="history")
