"""The page's address: what it names of a session, so that it can be loaded again or sent to a colleague.

An example is ``?recording=a.mcap&damper=front_left&model=mine.yaml&session=NAME&step=2&tab=steps&from=1.5&to=3``;
``dampers=all`` shows all dampers side by side. With ``session`` the steps are read from that session's file; without,
or where the file has gone, recordings and models are opened.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import parse_qs

import numpy as np

from damper_estimator.studio.stage import Choice

LONGEST = 8000  # characters
_MOST = 50  # values of one name


@dataclass(frozen=True)
class Address:
    """What an address says.

    Attributes:
        choice, models: what to open.
        session: name of its file; "" for none.
        step: index; None for the last.
        view: recording on view (index), start and stop (s; None for all).
        tab: of the panels; "" for the first.
        all_dampers: whether the overview of all dampers is on view.
    """

    choice: Choice
    models: tuple[str, ...] = ()
    session: str = ""
    step: int | None = None
    view: tuple[int, float | None, float | None] = (0, None, None)
    tab: str = ""
    all_dampers: bool = False

    @property
    def opens(self) -> bool:
        """Whether it names enough to open recordings."""
        return bool(self.choice.fit and self.models)


def parsed_address(query: object) -> Address:
    """An address from the part of a URL after the question mark; what it does not understand is left out."""
    text = query if isinstance(query, str) and len(query) <= LONGEST else ""
    try:
        given = parse_qs(text.lstrip("?"), max_num_fields=4 * _MOST)
    except ValueError:
        given = {}

    def last(name: str) -> str:
        return given.get(name, [""])[-1]

    choice = Choice(
        tuple(given.get("recording", ())[:_MOST]), tuple(given.get("unseen", ())[:_MOST]), last("damper"), last("map"),
        _number(last("start")), _number(last("stop")),
    )  # fmt: skip
    view = (_index(last("show")) or 0, _number(last("from")), _number(last("to")))
    models = tuple(given.get("model", ())[:_MOST])
    return Address(choice, models, last("session"), _index(last("step")), view, last("tab"), last("dampers") == "all")


def fields_of(choice: Choice, damper: str, models: tuple[str, ...], session: str, at: int) -> Mapping[str, object]:
    """The part of an address that the server knows; the page adds what is on view."""
    return {
        "recording": list(choice.fit),
        "unseen": list(choice.unseen),
        "damper": damper,
        "map": choice.signals,
        "start": choice.start,
        "stop": choice.stop,
        "model": list(models),
        "session": session,
        "step": at if session else None,
    }


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if np.isfinite(number) else None


def _index(text: str) -> int | None:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 7 else None
