"""The linked figures, what is on view in them, and where the model fails."""

from dash import ALL, ClientsideFunction, Dash, Input, Output, State, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.errors import InputError
from damper_estimator.report.figures import error_map
from damper_estimator.report.plots import Figure
from damper_estimator.report.theme import themed
from damper_estimator.studio import panels
from damper_estimator.studio.callbacks.common import clicked, opened
from damper_estimator.studio.callbacks.marking import viewed
from damper_estimator.studio.cursors import cursor_table, further_choices
from damper_estimator.studio.linked_figures import Scene, cloud_figure, time_figure
from damper_estimator.studio.marking import errors_in_words
from damper_estimator.studio.page_layout import names_of
from damper_estimator.studio.session import Session
from damper_estimator.studio.sessions import Sessions
from damper_estimator.studio.slider_preview import preview_force
from damper_estimator.studio.view import MOTIONS, View

_LINKED = {"type": "linked", "name": ALL}
_ABOUT = 1.0  # s before and after the worst moment of a region


def connect(app: Dash, sessions: Sessions) -> None:
    """What is on view is one store, which figures and lists change and from which all figures are drawn."""
    app.clientside_callback(
        ClientsideFunction("studio", "look"),
        Output("view", "data"),
        Input(_LINKED, "relayoutData"),
        Input(_LINKED, "clickData"),
        Input("back", "n_clicks"),
        Input("all", "n_clicks"),
        Input("unmark", "n_clicks"),
        Input("recording", "value"),
        State("tool", "value"),
        State("view", "data"),
        State("drawn", "data"),
        prevent_initial_call=True,
    )

    @app.callback(
        Output("view", "data", allow_duplicate=True),
        Input({"type": "region", "index": ALL}, "n_clicks"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def go(_clicks, page):
        place, session = clicked()["index"], opened(sessions, page)
        changed = _at_region(session, place) if session is not None else None
        if changed is None:
            raise PreventUpdate
        return changed

    _connect_figures(app, sessions)
    _connect_judgement(app, sessions)


def _connect_figures(app: Dash, sessions: Sessions) -> None:
    """The figure over time comes first, as it is the one that is zoomed; the clouds follow what it shows."""

    @app.callback(
        Output(_linked("time"), "figure"),
        Output("draw-message", "children"),
        Output("marked-summary", "children"),
        Output("marked-bar", "hidden"),
        Output("cursor-values", "children"),
        Output("left", "data-further"),
        Output("scene", "data"),
        Output("reported-drawn", "data"),
        Input("generation", "data"),
        Input("view", "data"),
        Input("preview", "data"),
        Input("theme", "data"),
        Input("tool", "value"),
        Input("traces", "value"),
        State("page", "data"),
    )
    def draw(generation, view, preview, theme, tool, traces, page):
        session = opened(sessions, page)
        if session is None or theme is None:
            raise PreventUpdate
        drawn = {"generation": generation, "theme": theme, "opened": session.opened}
        try:
            scene = _scene(session, view, preview, traces)
            way = "select" if tool == "lasso" else tool  # of a passage only its ends count
            figure = _styled(time_figure(scene), session, scene.view, way, theme)
        except InputError as error:
            return no_update, str(error), "", True, no_update, no_update, no_update, drawn
        shown = [generation, view, preview, theme, tool]
        return figure, "", *_marked_words(scene), cursor_table(scene), str(len(scene.further)), shown, drawn

    @app.callback(Output("traces", "options"), Input("generation", "data"), State("page", "data"))
    def offer(_, page):
        session = opened(sessions, page)
        return further_choices(session.stage.whole[0].kinematics) if session is not None else []

    @app.callback(
        *(Output(_linked(motion), "figure") for motion in MOTIONS), Input("scene", "data"), State("page", "data")
    )
    def draw_clouds(shown, page):
        session = opened(sessions, page)
        if session is None or shown is None:
            raise PreventUpdate
        _, view, preview, theme, tool = shown
        try:
            scene = _scene(session, view, preview)
            clouds = [cloud_figure(scene, motion) for motion in MOTIONS]
        except InputError as error:  # what was shown is gone: another draw is on its way
            raise PreventUpdate from error
        return tuple(_styled(cloud, session, scene.view, tool, theme) for cloud in clouds)


def _connect_judgement(app: Dash, sessions: Sessions) -> None:
    """How well the models agree, and where the one that is worked on fails."""

    @app.callback(Output("measures", "children"), Input("generation", "data"), State("page", "data"))
    def agree(_, page):
        session = opened(sessions, page)
        if session is None:
            raise PreventUpdate
        models = session.models()
        return panels.measures_table([session.shown(model) for model in models], _names(session))

    @app.callback(
        Output("verdict", "children"),
        Output("regions", "children"),
        Output("error-map", "figure"),
        Output("quality", "children"),
        Output("data-summary", "children"),
        Input("drawn", "data"),  # people look before they read: the first picture does not wait for this
        State("page", "data"),
    )
    def judge(drawn, page):
        session = opened(sessions, page)
        if session is None or drawn is None:
            raise PreventUpdate
        theme = drawn["theme"]
        try:
            found = session.comparison(session.shown(session.model))
        except InputError as error:
            return str(error), "", no_update, "", ""
        warnings, over = session.stage.warnings, themed(error_map(found), theme)
        shown_parts = (
            panels.verdict(found, session.stage.note, warnings, _never_identified(session)),
            panels.regions(found),
            over,
        )
        return *shown_parts, panels.quality(found), panels.quality_line(found, warnings)


def _never_identified(session: Session) -> str:
    """The name of the model on view where nobody has identified it, neither here nor before; else ""."""
    done = {version.step.action for version in session.history.done}
    return session.model.name if not session.model.fit and done == {"start"} else ""


def _names(session: Session) -> list[str]:
    return names_of(session.models(), session.history.at > 0)


def _linked(name: str) -> dict[str, str]:
    return _LINKED | {"name": name}


def _at_region(session: Session, index: int) -> dict | None:
    """The view of the worst moment of a region; None where there is no such region."""
    found = session.comparison(session.shown(session.model)).regions
    if index >= len(found):
        return None
    passage = session.stage.judged[found[index].recording]
    time = passage.begin + found[index].time
    ends = {"start": time - _ABOUT, "stop": time + _ABOUT}
    return {"opened": session.opened, "recording": passage.recording, "mark": None} | ends


def _scene(session: Session, data: object, preview: dict | None, traces: object = ()) -> Scene:
    """What is to be drawn.

    Raises:
        InputError: for a view that no page of ours asks for, and parameters that give no force.
    """
    view = viewed(session, data)
    models = [session.shown(model) for model in session.models()]
    force = preview_force(models[0], preview["values"], view) if _is_current(session, preview) else None
    kinematics = session.stage.whole[view.recording].kinematics
    chosen = [str(trace) for trace in traces] if isinstance(traces, list | tuple) else []
    further = tuple(choice["value"] for choice in further_choices(kinematics) if choice["value"] in chosen)
    return Scene(models, _names(session), view, force, further)


def _styled(figure: Figure, session: Session, view: View, tool: str, theme: str) -> Figure:
    """A linked figure with the chosen tool and colours; it keeps the user's own zoom as long as the view stays."""
    figure["layout"] |= {
        "dragmode": False if tool == "cursor" else tool,
        "uirevision": f"{session.opened} {view.start} {view.stop}",
    }
    return themed(figure, theme)


def _is_current(session: Session, preview: dict | None) -> bool:
    """Whether a slider is being moved on the model that is on view."""
    return bool(preview) and preview.get("generation") == session.generation


def _marked_words(scene: Scene) -> tuple[str, bool]:
    """What the line says of the marked samples, and whether it is hidden."""
    if scene.marked is None:
        return "", True
    try:
        return errors_in_words(scene.models[0], scene.view, scene.names[0]), False
    except InputError as error:
        return str(error), False
