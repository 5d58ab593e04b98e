"""What can be done with a marked region, in a line above the figure over time."""

from dash import dcc, html


def marked_bar() -> list:
    """The line while something is marked, the line while something is left out, and a download."""
    buttons = [
        html.Button("fit on it", id="fit-marked", title="identify the free parameters on the marked samples alone"),
        html.Button("diagnose it", id="diagnose-marked", title="what the model lacks in the marked region"),
        html.Button("leave it out", id="leave-out", title="neither fit to the marked samples nor judge on them"),
        html.Button("CSV", id="export-marked", title="the marked samples as a table, all of them"),
        html.Button("unmark", id="unmark", title="take the marks away"),
    ]
    left_out = [html.Span("", id="left-out-words"), html.Button("take it back in", id="take-back")]
    return [
        html.Div([html.Span("", id="marked-summary"), *buttons], id="marked-bar", className="acts", hidden=True),
        html.Div(left_out, id="left-out", className="acts", hidden=True),
        dcc.Download(id="download"),
    ]
