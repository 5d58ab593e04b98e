"""The linked figures, what is on view in them, and where the model fails."""

from dash import ALL, Dash, Input, Output, State, ctx, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.errors import InputError
from damper_estimator.report.figures import error_map
from damper_estimator.studio import panels
from damper_estimator.studio.callbacks.common import opened
from damper_estimator.studio.figures import Scene, figures
from damper_estimator.studio.page import names_of
from damper_estimator.studio.paint import painted
from damper_estimator.studio.session import Session
from damper_estimator.studio.sessions import Sessions
from damper_estimator.studio.tried import tried_force
from damper_estimator.studio.view import View, mark_of, marked, parsed_view

_LINKED = {"type": "linked", "name": ALL}
_ABOUT = 1.0  # s before and after the worst moment of a region


def connect(app: Dash, sessions: Sessions) -> None:
    """What is on view is one store, which figures and lists change and from which all figures are drawn."""
    _connect_judgement(app, sessions)

    @app.callback(
        Output("view", "data"),
        Input(_LINKED, "relayoutData"),
        Input({"type": "region", "index": ALL}, "n_clicks"),
        Input("all", "n_clicks"),
        Input("unmark", "n_clicks"),
        Input("recording", "value"),
        State("view", "data"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def look(_changes, _regions, _all, _unmark, recording, view, page):
        session = opened(sessions, page)
        if session is None or not ctx.triggered[0]["value"] and ctx.triggered_id != "recording":
            raise PreventUpdate
        changed = _changed(session, dict(view or {}), ctx.triggered_id, ctx.triggered[0]["value"])
        if changed is None or changed == view:
            raise PreventUpdate
        return changed

    @app.callback(
        Output(_LINKED, "figure"),
        Output("draw-told", "children"),
        Output("marked-told", "children"),
        Output("drawn", "data"),
        Input("generation", "data"),
        Input("view", "data"),
        Input("tried", "data"),
        Input("theme", "data"),
        Input("tool", "value"),
        State("page", "data"),
        State("drawn", "data"),
    )
    def draw(generation, view, tried, theme, tool, page, before):
        session = opened(sessions, page)
        if session is None or theme is None:
            raise PreventUpdate
        wanted = [own["id"]["name"] for own in ctx.outputs_list[0]]
        now = no_update if [generation, theme] == before else [generation, theme]
        try:
            drawn, told = _drawn(session, view, tried, tool, theme)
        except InputError as error:
            return [no_update] * len(wanted), str(error), "", now
        return [drawn[name] for name in wanted], "", told, now


def _connect_judgement(app: Dash, sessions: Sessions) -> None:
    """How well the models agree, and where the one that is worked on fails."""

    @app.callback(Output("measures", "children"), Input("generation", "data"), State("page", "data"))
    def agree(_, page):
        session = opened(sessions, page)
        if session is None:
            raise PreventUpdate
        models = session.models()
        return panels.measures_table([session.shown(own) for own in models], _names(session))

    @app.callback(
        Output("verdict", "children"),
        Output("regions", "children"),
        Output("error-map", "figure"),
        Output("quality", "children"),
        Output("data-told", "children"),
        Input("drawn", "data"),  # people look before they read: the first picture does not wait for this
        State("page", "data"),
    )
    def judge(drawn, page):
        session = opened(sessions, page)
        if session is None or drawn is None:
            raise PreventUpdate
        theme = drawn[1]
        try:
            found = session.comparison(session.shown(session.model))
        except InputError as error:
            return str(error), "", no_update, "", ""
        warnings, over = session.stage.warnings, painted(error_map(found), theme)
        told = panels.verdict(found, session.stage.note, warnings), panels.regions(found), over
        return *told, panels.quality(found), panels.quality_line(found, warnings)


def _names(session: Session) -> list[str]:
    return names_of(session.models(), session.history.at > 0)


def _changed(session: Session, view: dict, cause: object, value: object) -> dict | None:
    """The view after something happened on the page; None where that is nothing to it."""
    if view.get("opened") != session.opened:
        view = {"opened": session.opened}
    if cause == "recording":
        return view if value == view.get("recording", 0) else {"opened": session.opened, "recording": value or 0}
    if cause == "unmark":
        return view | {"mark": None}
    if cause == "all":
        return view | {"start": None, "stop": None}
    if cause["type"] == "region":
        return _at_region(session, view, cause["index"])
    return _relaid(view, cause["name"], value)


def _relaid(view: dict, figure: str, change: dict) -> dict | None:
    """After zooming or marking in a figure."""
    if "selections" in change:
        return view | {"mark": mark_of(figure, change)}
    if figure != "time":
        return None
    if change.get("xaxis.autorange") or change.get("autosize") and "xaxis.range[0]" not in change:
        return view | {"start": None, "stop": None} if change.get("xaxis.autorange") else None
    if "xaxis.range[0]" in change:
        return view | {"start": change["xaxis.range[0]"], "stop": change["xaxis.range[1]"]}
    return None


def _at_region(session: Session, view: dict, index: int) -> dict | None:
    found = session.comparison(session.shown(session.model)).regions
    if index >= len(found):
        return None
    passage = session.stage.judged[found[index].recording]
    time = passage.begin + found[index].time
    return view | {"recording": passage.recording, "start": time - _ABOUT, "stop": time + _ABOUT, "mark": None}


def _drawn(session: Session, data: object, tried: dict | None, tool: str, theme: str) -> tuple[dict, str]:
    """The figures by name, and how much is marked."""
    current = data if (data or {}).get("opened") == session.opened else {}
    view = parsed_view(current, len(session.stage.whole))
    models = [session.shown(own) for own in session.models()]
    force = tried_force(models[0], tried["values"], view) if _is_tried(session, tried) else None
    drawn = figures(Scene(models, _names(session), view, force))
    for name, own in drawn.items():
        way = "select" if (name, tool) == ("time", "lasso") else tool  # of a passage only its ends count
        own["layout"] |= {"dragmode": way, "uirevision": f"{session.opened} {view.start} {view.stop}"}
    return {name: painted(own, theme) for name, own in drawn.items()}, _told(models[0], view)


def _is_tried(session: Session, tried: dict | None) -> bool:
    """Whether a slider is being moved on the model that is on view."""
    return bool(tried) and tried.get("generation") == session.generation


def _told(shown, view: View) -> str:
    inside = marked(shown, view)
    if inside is None:
        return ""
    error = shown.traces[view.recording].residual[inside & shown.traces[view.recording].judged]
    rms = float((error**2).mean() ** 0.5) if error.size else float("nan")
    return f"{int(inside.sum())} samples marked, rms error {rms:.3g} N"
