"""The cards of the library: what they say, that they follow the files, and that a damaged file says so."""

import time
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
from browser import needs_browser, needs_playwright
from studio_page import open_page, served

from damper_estimator.model import library_models, load_model
from damper_estimator.studio.cards import Card, Cards, characteristic
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.thumbnail import picture


def made(cards: Cards) -> dict[str, Card]:
    """The cards by name, when all are made."""
    end = time.monotonic() + 120.0
    while any(card.lines[:1] == ("looking into it ...",) for card in cards.now()):
        assert time.monotonic() < end
        time.sleep(0.05)
    return {card.name: card for card in cards.now()}


def test_cards_say_what_is_in_a_file_and_follow_it(folder, monkeypatch):
    monkeypatch.setattr("damper_estimator.studio.cards.library_models", dict)
    (folder / "cut.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes()[:3000])
    cards = Cards(Folder(folder))
    found = made(cards)
    card = found["hidden_fit.mcap"]
    assert "1 damper: passenger_front" in card.lines[0] and "Hz" in card.lines[1] and "force" in card.lines[2]
    assert card.picture and not card.bad
    assert found["cut.mcap"].bad.startswith(str(folder / "cut.mcap")) and not found["cut.mcap"].picture
    assert "13 parameters" in found["before.yaml"].lines[1] and found["before.yaml"].picture
    (folder / "cut.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes())
    end = time.monotonic() + 60.0
    while made(cards)["cut.mcap"].bad:
        assert time.monotonic() < end
        time.sleep(0.1)


def test_every_library_model_has_a_curve_and_says_what_it_needs():
    needs = {}
    for name, path in library_models().items():
        velocity, force, needs[name] = characteristic(load_model(path))
        assert np.isfinite(force).all() and force.shape == velocity.shape
    assert needs["semi_active_yield"] == ["command"] and needs["linear_viscous"] == []


def test_a_picture_is_an_image_of_the_curve():
    drawn = ElementTree.fromstring(unquote(picture(np.linspace(-1, 1, 50), np.linspace(-2, 2, 50)).partition(",")[2]))
    points = [tuple(map(float, pair.split(","))) for pair in drawn[1].get("points").split()]
    assert len(points) == 50 and points[0][1] > points[-1][1] and points[0][0] < points[-1][0]
    assert picture(np.full(5, np.nan), np.ones(5)) == ""


def test_a_search_looks_at_names_and_lines():
    card = Card("models", "semi", ("bouc_wen, coulomb", "needs displacement, command"))
    assert card.fits("") and card.fits("COMMAND semi") and not card.fits("semi temperature")


@needs_browser
@needs_playwright
def test_a_card_is_found_and_chosen(folder):
    with served(folder) as (_, url), open_page(url) as user:
        user.page.click("#library summary")
        user.page.fill("#search", "hidden_unseen")
        user.until(lambda: user.page.locator(".library-card").count() == 1)
        user.page.locator(".library-card").click()
        user.until(lambda: "hidden_unseen.mcap" in user.text_of("recordings"))
        assert not user.faults
