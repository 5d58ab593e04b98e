"""Tests: the diagrams of the open recordings, the next test, and rides; each result with its page."""

from dash import ALL, Dash, Input, Output, State, html
from dash.exceptions import PreventUpdate

from damper_estimator.studio import rig_tests
from damper_estimator.studio.callbacks.common import CHANGES, answered, clicked, opened
from damper_estimator.studio.rig_tasks import RigTest
from damper_estimator.studio.sessions import Sessions


def connect(app: Dash, sessions: Sessions) -> None:
    """Three buttons, the aims of a test, and the results."""

    @app.callback(*CHANGES, Output("tests-message", "children", allow_duplicate=True),
                  Input("characterize", "n_clicks"), State("page", "data"), prevent_initial_call=True)  # fmt: skip
    def characterize(_, page):
        return answered(sessions, page, rig_tests.characterize)

    @app.callback(*CHANGES, Output("tests-message", "children", allow_duplicate=True), Input("plan", "n_clicks"),
                  State("aim", "value"), State("rig", "value"), State("minutes", "value"), State("page", "data"),
                  prevent_initial_call=True)  # fmt: skip
    def plan(_, aim, rig, minutes, page):
        return answered(sessions, page, lambda session: rig_tests.plan(session, aim, rig, minutes))

    @app.callback(*CHANGES, Output("tests-message", "children", allow_duplicate=True), Input("ride", "n_clicks"),
                  State("ride-damper", "value"), State("ride-seconds", "value"), State("page", "data"),
                  prevent_initial_call=True)  # fmt: skip
    def ride(_, damper, seconds, page):
        return answered(sessions, page, lambda session: rig_tests.ride(session, damper, seconds))

    @app.callback(
        Output("tab", "value", allow_duplicate=True),
        Output("aim", "value", allow_duplicate=True),
        Input({"type": "plan-tie", "group": ALL}, "n_clicks"),
        prevent_initial_call=True,
    )
    def go_to_plan(_clicks):
        return "tests", clicked()["group"]

    @app.callback(
        Output("aim", "options"),
        Output("aim", "value"),
        Output("rig", "options"),
        Output("tests-done", "children"),
        Input("generation", "data"),
        State("aim", "value"),
        State("page", "data"),
    )
    def results(_, aim, page):
        session = opened(sessions, page)
        if session is None:
            raise PreventUpdate
        aims = rig_tests.aims(session.diagnosis)
        options = [{"label": text, "value": value} for value, text in aims.items()]
        listed = [_result(test, page, number) for number, test in reversed(list(enumerate(session.tests)))]
        return options, aim if aim in aims else next(iter(aims)), rig_tests.rigs(session.folder), listed


def _result(test: RigTest, page: str, number: int) -> html.Section:
    link = html.A("open the page", href=f"/test/{page}/{number}", target="_blank", rel="noopener")
    files = ", ".join((test.page, *test.files))
    steps = [html.Details([html.Summary(f"{len(test.steps)} steps"), html.Ol([html.Li(step) for step in test.steps])])]
    where = html.P([link, html.Small(f" {files} in {test.folder}")])
    return html.Section(
        [html.H3(test.title), html.P(test.sentence), *(steps if test.steps else []), where],
        className="test-result",
    )
