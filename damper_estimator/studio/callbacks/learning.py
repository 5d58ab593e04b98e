"""What is missing: the diagnosis, its ranking, and what each effect would explain."""

from dash import Dash, Input, Output, State, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.diagnosis import MODES, Diagnosis
from damper_estimator.effects.discovery import all_effects
from damper_estimator.errors import InputError
from damper_estimator.report.curve_figures import command_unit, curves_figure, left_out
from damper_estimator.report.diagnosis_page import tied_notes
from damper_estimator.report.diagnosis_wording import plain_name
from damper_estimator.report.theme import height_style, themed
from damper_estimator.report.verdict_figures import atlas_figure, ranking_figure
from damper_estimator.studio import panels
from damper_estimator.studio.callbacks.common import CHANGES, answered, opened
from damper_estimator.studio.components import EMPTY
from damper_estimator.studio.explained import explained_figure
from damper_estimator.studio.sessions import Sessions

_NARROW = 22  # characters of a name in the panel


def connect(app: Dash, sessions: Sessions) -> None:
    """Two buttons begin the work, its result is shown when it is there."""
    for name in ("diagnose", "improve"):
        _button(app, sessions, name)

    @app.callback(
        Output("findings", "children"),
        Output("ranking", "figure"),
        Output("ranking", "style"),
        Output("atlas", "figure"),
        Output("atlas", "style"),
        Output("curves", "figure"),
        Output("curves", "style"),
        Output("curves-left-out", "children"),
        Output("candidates", "children"),
        Output("ranked", "hidden"),
        Input("generation", "data"),
        Input("theme", "data"),
        State("page", "data"),
    )
    def show_findings(_, theme, page):
        session = opened(sessions, page)
        if session is None or theme is None:
            raise PreventUpdate
        found = session.diagnosis
        if found is None:
            hint = "Diagnose tries every physical effect on the model and judges it on data that it was not fitted to."
            return hint, *[no_update] * 7, "", True
        drawn = ranking_figure(found.ranking, found.findings, tied_notes(found))
        listed = panels.findings(found, found.model != session.model, session.diagnosed)
        atlas = atlas_figure(found.atlas, found.findings, _NARROW)
        curves = curves_figure(found.curves, command_unit(found))
        figures = [part for figure in (drawn, atlas, curves) for part in (themed(figure, theme), height_style(figure))]
        return listed, *figures, left_out(found.curves), panels.candidates(found), False

    @app.callback(
        Output("looked", "hidden"),
        Output("looked-name", "children"),
        Output("explained", "figure"),
        Output("equation", "children"),
        Input("hovered", "data"),
        Input("theme", "data"),
        Input("generation", "data"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def look(effect, theme, _, page):
        session = opened(sessions, page)
        if session is None or session.diagnosis is None or effect not in all_effects():
            return True, "", EMPTY, ""
        drawn = explained_figure(session.diagnosis, effect)
        return False, _title(session.diagnosis, effect), themed(drawn, theme), panels.equation(effect)


def _button(app: Dash, sessions: Sessions, name: str) -> None:
    @app.callback(
        *CHANGES,
        Output("learn-message", "children", allow_duplicate=True),
        Input(name, "n_clicks"),
        State("mode", "value"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def begin(_, mode, page):
        def verb(session) -> None:
            if mode not in MODES:
                raise InputError("choose how effects are judged")
            getattr(session, name)(mode)

        return answered(sessions, page, verb)


def _title(found: Diagnosis, effect: str) -> str:
    phenomenon = next((ranked.phenomenon for ranked in found.ranking if ranked.effect == effect), "")
    return f"{plain_name(phenomenon)} by {effect}" if phenomenon else effect
