"""The library: cards of recordings and models, a search, and a click that chooses."""

from dash import ALL, Dash, Input, Output, State, html, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.studio.callbacks.common import clicked
from damper_estimator.studio.cards import Card, Cards
from damper_estimator.studio.sessions import Sessions

_CARD = {"type": "card", "kind": ALL, "name": ALL}


def connect(app: Dash, sessions: Sessions) -> None:
    """The cards follow the folder and the search."""
    cards = Cards(sessions.folder)

    @app.callback(
        Output("cards", "children"),
        Output("carded", "data"),
        Input("notice", "n_intervals"),
        Input("search", "value"),
        Input("library", "open"),
        State("carded", "data"),
        prevent_initial_call=True,
    )
    def show(_, words, unfolded, before):
        if not unfolded:
            raise PreventUpdate
        chosen = [card for card in cards.now() if card.fits(str(words or ""))]
        now = [[card.kind, card.name, *card.lines, card.bad] for card in chosen]
        if now == before:
            raise PreventUpdate
        return [_drawn(card) for card in chosen] or "nothing fits the search", now

    @app.callback(
        Output("recordings", "value", allow_duplicate=True),
        Output("models", "value", allow_duplicate=True),
        Input(_CARD, "n_clicks"),
        State("recordings", "value"),
        State("models", "value"),
        prevent_initial_call=True,
    )
    def choose(_clicks, recordings, models):
        card = clicked()
        kind, name = card["kind"], card["name"]
        chosen = list((recordings if kind == "recordings" else models) or [])
        chosen = [other for other in chosen if other != name] if name in chosen else [*chosen, name]
        return (chosen, no_update) if kind == "recordings" else (no_update, chosen)


def _drawn(card: Card) -> html.Button:
    image = html.Img(src=card.picture, alt=f"force over velocity of {card.name}") if card.picture else html.Span()
    lines = [html.Small(text) for text in card.lines]
    bad = [html.Small(f"⚠ {card.bad}", className="bad")] if card.bad else []
    title = html.B([html.I(card.kind.rstrip("s"), className="kind"), " ", card.name])
    identity = {"type": "card", "kind": card.kind, "name": card.name}
    return html.Button([image, html.Span([title, *lines, *bad])], id=identity, className="library-card")
