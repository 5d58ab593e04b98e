"""Changing the model: adding and taking out effects, refitting, parameters by hand; and the steps that were done."""

from types import SimpleNamespace

import numpy as np
from dash import ALL, ClientsideFunction, Dash, Input, Output, State, ctx, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.errors import InputError
from damper_estimator.model import Slot
from damper_estimator.report.diagnosis_wording import step_name
from damper_estimator.report.plots import Figure
from damper_estimator.report.theme import height_style, themed
from damper_estimator.report.verdict_figures import error_bars, waterfall_figure
from damper_estimator.studio import panels
from damper_estimator.studio.callbacks.common import CHANGES, answered, clicked, opened
from damper_estimator.studio.history import History
from damper_estimator.studio.parameters import parameter_list
from damper_estimator.studio.scale import from_place, to_place
from damper_estimator.studio.session import Session
from damper_estimator.studio.sessions import Sessions

_AT_REST = 0.002  # of a slider: it reports its place also where nobody moves it
_WIDTH = 1.4  # of the largest bar: the text next to it fits into the narrow panel
_SLIDER, _NUMBER, _FREE = ({"type": kind, "address": ALL} for kind in ("slider", "number", "free"))


def connect(app: Dash, sessions: Sessions) -> None:
    """Buttons, then the controls of the parameters, then what shows them."""
    _connect_buttons(app, sessions)
    _connect_parameters(app, sessions)
    _connect_shown(app, sessions)


def _connect_buttons(app: Dash, sessions: Sessions) -> None:
    @app.callback(
        *CHANGES,
        Output("change-message", "children", allow_duplicate=True),
        Output("learn-message", "children", allow_duplicate=True),
        Input({"type": "add", "effect": ALL, "from": ALL}, "n_clicks"),
        Input({"type": "remove", "label": ALL}, "n_clicks"),
        Input("add-effect", "n_clicks"),
        Input("refit", "n_clicks"),
        Input({"type": "refit", "from": ALL}, "n_clicks"),
        State("effect", "value"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def change(_add, _remove, _other, _refit, _offered, effect, page):
        cause = clicked()
        *changes, message = answered(sessions, page, lambda session: _change(session, cause, effect))
        return *changes, message, message


def _change(session: Session, cause: object, effect: str | None) -> None:
    if cause == "refit" or (isinstance(cause, dict) and cause["type"] == "refit"):
        session.refit()
    elif cause == "add-effect":
        if not effect:
            raise InputError("choose an effect to add")
        session.add(effect)
    elif cause["type"] == "add":
        session.add(cause["effect"])
    else:
        session.remove(cause["label"])


def _connect_parameters(app: Dash, sessions: Sessions) -> None:
    app.clientside_callback(
        ClientsideFunction("studio", "stale"),
        Output("studio", "data-stale"),
        Input("preview", "data"),
        Input("generation", "data"),
    )
    app.clientside_callback(
        ClientsideFunction("studio", "dragged"), Output("dragged", "data"), Input(_SLIDER, "drag_value")
    )

    @app.callback(
        *CHANGES,
        Output("change-message", "children", allow_duplicate=True),
        Output("preview", "data"),
        Output(_SLIDER, "value"),
        Output(_NUMBER, "value"),
        Input("dragged", "data"),
        Input(_SLIDER, "value"),
        Input(_NUMBER, "value"),
        State(_NUMBER, "id"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def move(dragged, places, numbers, ids, page):
        session = opened(sessions, page)
        addresses = [entry["address"] for entry in ids]
        if session is None or [s.address for s in session.model.slots] != addresses:
            raise PreventUpdate
        return _moved(sessions, session, page, _wanted(session, addresses, dragged, places, numbers), addresses)

    @app.callback(*CHANGES, Output("change-message", "children", allow_duplicate=True), Input(_FREE, "value"),
                  State(_FREE, "id"), State("page", "data"), prevent_initial_call=True)  # fmt: skip
    def free(chosen, ids, page):
        session = opened(sessions, page)
        fixed = [entry["address"] for entry, value in zip(ids, chosen, strict=True) if not value]
        if session is None or set(fixed) == {slot.address for slot in session.model.slots if slot.fixed}:
            raise PreventUpdate
        return answered(sessions, page, lambda changed: changed.fix(fixed))


def _wanted(session: Session, addresses: list[str], dragged: object, places: list, numbers: list) -> tuple:
    """Which parameter is to have which value, and whether its slider is still being moved."""
    cause = ctx.triggered_id
    if cause == "dragged":
        if not dragged or dragged["address"] not in addresses:
            raise PreventUpdate
        return dragged["address"], _value(session, dragged["address"], dragged["place"]), True
    if not isinstance(cause, dict):
        raise PreventUpdate
    index = addresses.index(cause["address"])
    if cause["type"] == "slider":
        return cause["address"], _value(session, cause["address"], places[index]), False
    if numbers[index] is None:
        raise InputError("give a number")
    return cause["address"], float(numbers[index]), False


def _value(session: Session, address: str, place: float) -> float:
    slot = next(candidate for candidate in session.model.slots if candidate.address == address)
    low, high = slot.parameter.lower, slot.parameter.upper
    return from_place(float(place), session.centres[address], low, high)


def _place(session: Session, slot: Slot, value: float) -> float:
    return to_place(value, session.centres[slot.address], slot.parameter.lower, slot.parameter.upper)


def _moved(sessions: Sessions, session: Session, page: str, wanted: tuple, addresses: list[str]) -> tuple:
    address, value, moving = wanted
    slots = {slot.address: slot for slot in session.model.slots}
    now = slots[address].value
    untouched = [no_update] * len(addresses)
    if moving:
        numbers = [float(f"{value:.6g}") if other == address else no_update for other in addresses]
        moved = abs(_place(session, slots[address], value) - _place(session, slots[address], now)) > _AT_REST
        preview = {"generation": session.generation, "values": {address: value}} if moved else None
        return no_update, no_update, no_update, preview, untouched, numbers
    if abs(value - now) <= 1e-5 * abs(now):  # what was shown with six digits and came back
        raise PreventUpdate
    *changes, message = answered(sessions, page, lambda changed: changed.set(address, value))
    value = now if message else value
    place = _place(session, slots[address], value)
    sliders = [place if slider_address == address else no_update for slider_address in addresses]
    numbers = [float(f"{value:.6g}") if other == address else no_update for other in addresses]
    return *changes, message, None, sliders, numbers


def _connect_shown(app: Dash, sessions: Sessions) -> None:
    @app.callback(Output("parameters", "children"), Input("rebuilt", "data"), State("page", "data"))
    def parameters(_, page):
        session = opened(sessions, page)
        if session is None:
            raise PreventUpdate
        return parameter_list(session.model)

    @app.callback(
        Output("waterfall", "figure"),
        Output("waterfall", "style"),
        Output("steps", "children"),
        Input("drawn", "data"),
        State("page", "data"),
    )
    def steps(drawn, page):
        session = opened(sessions, page)
        if session is None or drawn is None:
            raise PreventUpdate
        theme = drawn["theme"]
        history = session.history
        floor = session.comparison(session.shown(session.model)).noise_floor_n
        errors = [version.step.rmse_unseen_n for version in history.versions]
        names = [step_name(version.step) for version in history.versions]
        files = [session.saved_as(version) for version in history.versions]
        listed = panels.steps_list(errors, names, files, history.at)
        reference = session.diagnosis.reference_n if session.diagnosis else float("nan")
        drawn = _steps_figure(history, floor, session.shown(session.model).measures.force_rms_n, reference)
        return themed(drawn, theme), height_style(drawn), listed


def _steps_figure(history: History, floor_n: float, force_n: float, reference_n: float) -> Figure:
    """The error of the model as given, or what each step took off it."""
    steps = [version.step for version in history.done]
    if len(steps) == 1:
        return error_bars([(step_name(steps[0]), steps[0].rmse_unseen_n)], floor_n, force_n, reference_n)
    drawn = waterfall_figure(SimpleNamespace(steps=steps, noise_floor_n=floor_n, reference_n=reference_n))
    drawn["layout"]["xaxis"]["range"] = [
        0.0,
        _WIDTH * max(*(step.rmse_unseen_n for step in steps), np.nan_to_num(reference_n)),
    ]
    return drawn
