"""What happens on the page: from its controls to the session's verbs, from the session to figures and words."""

from dash import Dash

from damper_estimator.studio.callbacks import (
    arriving,
    browsing,
    changing,
    importing,
    learning,
    living,
    looking,
    marking,
    opening,
    overview,
    page_itself,
    saving,
)
from damper_estimator.studio.callbacks.common import hand_on
from damper_estimator.studio.live import Live
from damper_estimator.studio.sessions import Sessions

_PARTS = (
    arriving, browsing, page_itself, importing, opening, overview, looking, marking, learning, changing, saving,
)  # fmt: skip


def connect(app: Dash, sessions: Sessions, live: Live | None = None) -> None:
    """Gives an application all callbacks; those of a running node where it listens to one."""
    hand_on(app)
    for part in _PARTS:
        part.connect(app, sessions)
    if live is not None:
        living.connect(app, sessions, live)
