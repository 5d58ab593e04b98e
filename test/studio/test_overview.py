"""All dampers at once: compared, diagnosed and improved in one go, and each of them opened in depth and left again."""

import shutil

import pytest
from browser import needs_browser, needs_playwright
from studio_page import BAGS, open_page, served

from damper_estimator.errors import InputError
from damper_estimator.model import load_model
from damper_estimator.studio.corners import place
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.session import Session
from damper_estimator.studio.stage import Choice

CORNERS = ["front_left", "front_right", "rear_left", "rear_right"]
BAG = "four_corners_road.mcap"


@pytest.fixture
def car(tmp_path):
    shutil.copy(BAGS / BAG, tmp_path)
    return tmp_path


@pytest.fixture
def session(car):
    session = Session(Folder(car))
    session.open(Choice((BAG,), stop=5.0), ["linear_viscous"])
    finished(session)
    yield session
    session.close()


def finished(session):
    session.job.wait()
    assert session.job.state == "done", session.job.error


def test_dampers_stand_as_in_the_car():
    assert sorted(["rear_right", "front_right", "rear_left", "front_left"], key=place) == CORNERS
    assert sorted(["RR", "FR", "RL", "FL"], key=place) == ["FL", "FR", "RL", "RR"]


def test_every_damper_is_compared_as_it_would_be_alone(session):
    session.work_on_all("compare", "kept")
    finished(session)
    assert sorted(session.corners, key=place) == CORNERS
    for name in CORNERS[:2]:
        session.open_damper(name)
        if session.busy:
            finished(session)
        record = session.shown(session.model).measures.record()
        assert session.corners[name].rms.split()[0] == f"{record['rmse_n']:.3g}"


def test_steps_on_one_damper_are_there_when_it_is_opened_again(session):
    session.work_on_all("compare", "kept")
    finished(session)
    session.refit()
    finished(session)
    first, history, file = session.stage.damper, session.history, session.writer.name
    other = next(name for name in CORNERS if name != first)
    session.open_damper(other)
    finished(session)
    assert session.stage.damper == other and session.history.at == 0
    session.open_damper(first)
    finished(session)
    assert session.history is history and session.writer.name == file
    with pytest.raises(InputError, match="not a damper"):
        session.open_damper("../elsewhere")


def test_all_are_improved_in_one_go_kept_and_saved(session, car):
    session.work_on_all("improve", "kept")
    finished(session)
    histories = session.histories()
    assert sorted(histories, key=place) == CORNERS
    for name, history in histories.items():
        errors = [version.step.rmse_unseen_n for version in history.versions]
        assert history.at == 0 or errors[-1] < errors[0], name
    stepped = [name for name, steps in histories.items() if steps.at]
    assert stepped and len(list((car / ".damper_studio").glob("*.json"))) == len(stepped)
    assert "improved" in session.save_all()
    for name in CORNERS:
        assert load_model(car / "improved" / f"{name}.yaml").slots
    assert "improved_2" in session.save_all()


@needs_browser
@needs_playwright
def test_from_the_overview_into_one_damper_and_back(car):
    with served(car) as (_, url), open_page(url, 1400, 900) as user:
        page = user.page
        user.open([BAG], ["linear_viscous"], stop=5.0)
        user.until(page.locator("#overview").is_visible)
        page.click("#overview")
        user.done("comparing all")
        user.until(lambda: page.locator(".corner").count() == 4)
        titles = [text.split()[0] for text in page.locator(".corner h2").all_inner_texts()]
        assert titles == CORNERS
        assert all("N" in text for text in page.locator(".corner .facts").all_inner_texts())
        user.until(lambda: "dampers=all" in page.url)
        page.reload()
        user.done("comparing all")
        user.until(lambda: page.locator(".corner").count() == 4)
        assert not page.locator(".figure.time").is_visible()
        page.locator(".corner").nth(3).get_by_role("button").click()
        user.done("opening")
        user.until(lambda: "rear_right" in user.text_of("opened"))
        user.until(page.locator(".figure.time").is_visible)
        user.until(lambda: "dampers=all" not in page.url)
        user.tab("Model")
        page.click("#refit")
        user.done("identifying")
        page.click("#overview")
        user.until(lambda: "Changed since" in page.locator(".corner").nth(3).inner_text())
        page.click("#compare-all")
        user.until(lambda: "refit" in page.locator(".corner").nth(3).inner_text())
        user.until(lambda: "Changed since" not in user.text_of("corners"))
        assert not user.faults and not user.foreign
