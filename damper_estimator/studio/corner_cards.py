"""The cards of the overview: one damper each, placed as in the car."""

from dash import html

from damper_estimator.numbers import number
from damper_estimator.report.diagnosis_wording import step_name
from damper_estimator.studio.corners import Corner, place
from damper_estimator.studio.session import Session


def corners_section() -> html.Section:
    """The overview's place on the page."""
    buttons = [
        html.Button("Compare all", id="compare-all", title="error and worst region of every damper"),
        html.Button("Diagnose all", id="diagnose-all", title="what each damper's model lacks"),
        html.Button("Improve all", id="improve-all", title="diagnose, add and refit every damper's model"),
        html.Button("Save all models", id="save-all", disabled=True, title="one model file for each damper"),
    ]
    title = html.Div([html.H2("All dampers"), *buttons], className="title")
    return html.Section(
        [title, html.P("", id="corners-message", className="message"), html.Div(id="corner-cards")], id="corners"
    )


def corner_cards(session: Session) -> html.Div:
    """One card per damper."""
    cards = [_card(session, corner) for corner in sorted(session.corners.values(), key=lambda each: place(each.damper))]
    return html.Div(cards, className="corner-grid")


def _card(session: Session, corner: Corner) -> html.Section:
    name = corner.damper
    here = html.Small(" open") if name == session.stage.damper else ""
    button = html.Button("Open", id={"type": "corner", "damper": name}, className="primary")
    title = html.Div([html.H2([name, here]), "" if corner.failed else button], className="title")
    if corner.failed:
        return html.Section([title, html.P(corner.failed, className="warning")], className="card corner")
    history = session.histories().get(name, corner.history)
    steps = [step_name(version.step) for version in history.done[1:]]
    verdict = corner.verdict or "not diagnosed yet"
    facts = [(corner.rms, "rms error"), (corner.relative, "of the force"), (str(len(steps)), "steps")]
    lines = [html.P([html.Span("worst region", className="label"), corner.worst])]
    lines.append(html.P([html.Span("diagnosis", className="label"), verdict]))
    if steps:
        first, last = (version.step.rmse_unseen_n for version in (history.versions[0], history.now))
        words = f"{', '.join(steps)}: {number(first)} → {number(last)} N on unseen data"
        lines.append(html.P([html.Span("what was done", className="label"), words]))
    if len(history.done) != len(corner.history.done):
        lines.append(html.P("Changed since: compare all again.", className="warning"))
    image = html.Img(src=corner.picture, alt=f"force over velocity of {name}, measured grey, modelled blue")
    words = html.Div([html.Ul([html.Li([html.B(v), html.Span(k)]) for v, k in facts], className="facts"), *lines])
    return html.Section([title, html.Div([image, words], className="corner-body")], className="card corner")
