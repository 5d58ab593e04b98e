"""What happens on the page: from its controls to the session's verbs, from the session to figures and words."""

from dash import Dash

from damper_estimator.studio.callbacks import (
    arriving,
    browsing,
    changing,
    importing,
    learning,
    live_inputs,
    marking,
    opening,
    overview,
    page_itself,
    rig_testing,
    saving,
    viewing,
)
from damper_estimator.studio.callbacks.common import forward_changes
from damper_estimator.studio.live import Live
from damper_estimator.studio.sessions import Sessions

_PARTS = (
    arriving, browsing, page_itself, importing, opening, overview, viewing, marking, learning, changing, rig_testing,
    saving,
)  # fmt: skip


def connect(app: Dash, sessions: Sessions, live: Live | None = None) -> None:
    """Gives an application all callbacks; those of a running node where it listens to one."""
    forward_changes(app)
    for part in _PARTS:
        part.connect(app, sessions)
    if live is not None:
        live_inputs.connect(app, sessions, live)
