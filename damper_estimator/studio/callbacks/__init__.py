"""What happens on the page: from its controls to the session's verbs, from the session to figures and words."""

from dash import Dash

from damper_estimator.studio.callbacks import changing, learning, looking, opening, page_itself, saving
from damper_estimator.studio.callbacks.common import hand_on
from damper_estimator.studio.sessions import Sessions


def connect(app: Dash, sessions: Sessions) -> None:
    """Gives an application all callbacks."""
    hand_on(app)
    for part in (page_itself, opening, looking, learning, changing, saving):
        part.connect(app, sessions)
